-- What plays: a clock for each server, set by its messages, which lights up words and moves the status line on.

local server = require("improv.server")
local words = require("improv.words")

local M = {}

local AHEAD = 3 -- seconds for which words are to be known; the server tells where it is each second
local SHORTEST = 15 -- milliseconds between two looks: what is shorter than that, nobody sees

-- By server: `transport` as last heard, at `heard` (seconds by our clock), the `words` of each generation, which change
-- hands when the stage says so, and a `timer`, which runs only while something plays. Only messages of the server make
-- one: a status line may still be drawn for a server that has ended, and others than ours come and go.
local players = {}

local function player_of(id)
  players[id] = players[id] or { words = {}, timer = assert(vim.uv.new_timer()), watched = true }
  return players[id]
end

local function words_of(id)
  return players[id] and players[id].words or {}
end

local function seconds()
  return vim.uv.hrtime() / 1e9
end

--- Seconds that a message has been on its way; at most one, should the server's clock be another's.
local function age(wall)
  local whole, millionths = vim.uv.gettimeofday()
  return math.min(math.max(whole + millionths / 1e6 - wall, 0), 1)
end

local function beat_of(player)
  local told = player.transport
  local passed = told.state == "playing" and (seconds() - player.heard) * told.tempo / 60 or 0
  return math.min(told.beat + passed, told.beats or math.huge)
end

--- Whether a robot is told to stand still while others play.
local function silence(transport)
  local muted, soloed = transport.muted, transport.soloed
  return function(robot)
    if #soloed > 0 then
      return not vim.tbl_contains(soloed, robot)
    end
    return vim.tbl_contains(muted, robot)
  end
end

local function is_under_way(player)
  return player and player.transport and (player.transport.state == "playing" or player.transport.state == "paused")
end

local function drop(player, generation)
  if player.words[generation] then
    words.clear(player.words[generation])
    player.words[generation] = nil
  end
end

--- Show where it is, and come again when that changes.
local function show(player)
  player.timer:stop()
  if not player.transport then
    return
  end
  local told, beat, change = player.transport, beat_of(player), math.huge
  local current = player.words[told.generation]
  if current and vim.g.improv_playing == false then
    words.darken(current)
  elseif current and is_under_way(player) then
    change = words.light(current, beat, silence(told))
  end
  if player.watched and player.shown ~= told.state .. math.floor(beat) then
    player.shown, player.watched = told.state .. math.floor(beat), false
    vim.cmd.redrawstatus { bang = true }
  end
  if told.state == "playing" then
    local wait = (math.min(change, math.floor(beat) + 1) - beat) * 60 / told.tempo
    player.timer:start(math.max(math.ceil(wait * 1000), SHORTEST), 0, vim.schedule_wrap(function()
      if not player.timer:is_closing() then
        show(player)
      end
    end))
  end
end

--- Without JSON's nulls, which Neovim 0.12 keeps apart from what is missing.
local function without_nulls(object)
  for name, value in pairs(object) do
    if value == vim.NIL then
      object[name] = nil
    end
  end
  return object
end

--- The buffer of what plays, if it is open.
local function buffer_of(client, uri)
  for buffer in pairs(client.attached_buffers) do
    if vim.api.nvim_buf_is_loaded(buffer) and vim.uri_from_bufnr(buffer) == uri then
      return buffer
    end
  end
end

--- Mark the words that the server has told, unless the text is another meanwhile: then the answer is false.
local function take(client, told, from)
  local player, buffer = player_of(client.id), buffer_of(client, told.uri)
  if not buffer then
    return true
  end
  if vim.lsp.util.buf_versions[buffer] ~= told.version then
    return false
  end
  vim.tbl_map(without_nulls, told.robots)
  drop(player, told.generation)
  player.words[told.generation] = words.place(buffer, client.offset_encoding, told, from)
  show(player)
  return true
end

--- Have the server tell what plays from a beat on.
local function ask(client, buffer, beat)
  server.request(client, "improv/moments", { beat = beat }, function(_, told)
    if told and told.ranges and is_under_way(players[client.id]) then
      take(client, told, beat) -- if that fails, the next message of the transport has us ask again
    end
  end, buffer)
end

local function is_known(current, beat, ahead)
  if not current or beat < current.from then
    return false
  end
  for _, stretch in pairs(current.robots) do
    if stretch["until"] and stretch["until"] < ahead then
      return false
    end
  end
  return true
end

--- `improv/evaluated`: a program has been saved and plays, or will when the one before lets it.
function M.evaluated(id, told)
  local client = vim.lsp.get_client_by_id(id)
  if client and not take(client, told, 0) then
    ask(client, buffer_of(client, told.uri), 0)
  end
end

--- `improv/transport`: where it is, or what has become of it.
function M.transport(id, told)
  local client, player = vim.lsp.get_client_by_id(id), player_of(id)
  player.transport, player.heard, player.shown = without_nulls(told), seconds() - age(told.wall), nil
  for generation in pairs(player.words) do
    if generation < told.generation or not (is_under_way(player) or told.state == "waiting") then
      drop(player, generation)
    end
  end
  show(player)
  local buffer = client and told.uri and buffer_of(client, told.uri)
  local beat = beat_of(player)
  local known = is_known(player.words[told.generation], beat, beat + AHEAD * told.tempo / 60)
  if buffer and is_under_way(player) and not known then
    ask(client, buffer, beat)
  end
end

--- What plays, in one line.
function M.status(id)
  local player = players[id]
  local told = player and player.transport
  if not told then
    return "Improv"
  end
  player.watched = true
  if told.state == "waiting" then
    return ("… waits for robots, %s"):format(told.backend)
  elseif not is_under_way(player) then
    return ("■ %s"):format(told.state)
  end
  local sign = told.state == "playing" and "▶" or "‖"
  local whole = told.beats and math.max(math.ceil(told.beats), 1)
  local beat = math.min(math.floor(beat_of(player)) + 1, whole or math.huge)
  return ("%s beat %d/%s, %g bpm, %s"):format(sign, beat, whole or "∞", told.tempo, told.backend)
end

--- The transport as last heard.
function M.told(id)
  return players[id] and players[id].transport or {}
end

--- The robots of what plays.
function M.robots(id)
  local found = {}
  for _, each in pairs(words_of(id)) do
    vim.list_extend(found, vim.tbl_keys(each.robots))
  end
  table.sort(found)
  return vim.fn.uniq(found)
end

--- A server that no longer serves a buffer leaves nothing in it.
function M.leave(id, buffer)
  for generation, each in pairs(words_of(id)) do
    if each.buffer == buffer then
      drop(players[id], generation)
    end
  end
end

--- A server that has ended leaves nothing at all.
function M.forget(id)
  local player = players[id]
  if player then
    for generation in pairs(player.words) do
      drop(player, generation)
    end
    player.timer:close()
    players[id] = nil
    vim.cmd.redrawstatus { bang = true }
  end
end

return M
