-- What plays: a clock for each server, set by its messages. It highlights words and updates the status line.

local server = require("improv.server")
local words = require("improv.words")

local M = {}

local AHEAD = 3 -- seconds for which the words must be known; the server reports its clock each second
local SHORTEST = 15 -- milliseconds between two updates; nobody sees a shorter time

-- For each server: the last `transport`, when it was `heard` (seconds on our clock), the `words` of each generation
-- (the next one may already wait), and a `timer`, which runs only while something plays. Only the server's messages
-- create an entry, because a status line may still be drawn for a server that has ended.
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

--- How many seconds a message took. At most one: a larger difference means that the clocks differ.
local function age(wall)
  local whole, millionths = vim.uv.gettimeofday()
  return math.min(math.max(whole + millionths / 1e6 - wall, 0), 1)
end

local function beat_of(player)
  local transport = player.transport
  local passed = transport.state == "playing" and (seconds() - player.heard) * transport.tempo / 60 or 0
  return math.min(transport.beat + passed, transport.beats or math.huge)
end

--- A function that returns whether a robot stands still while others play.
local function silence(transport)
  local muted, soloed = transport.muted, transport.soloed
  return function(robot)
    if #soloed > 0 then
      return not vim.tbl_contains(soloed, robot)
    end
    return vim.tbl_contains(muted, robot)
  end
end

local function is_active(player)
  return player and player.transport and (player.transport.state == "playing" or player.transport.state == "paused")
end

local function drop(player, generation)
  if player.words[generation] then
    words.clear(player.words[generation])
    player.words[generation] = nil
  end
end

--- Show the state of playback, and again when it changes.
local function show(player)
  player.timer:stop()
  if not player.transport then
    return
  end
  local told, beat, change = player.transport, beat_of(player), math.huge
  local current = player.words[told.generation]
  if current and vim.g.improv_playing == false then
    words.darken(current)
  elseif current and is_active(player) then
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

--- Remove JSON's nulls, which Neovim 0.12 represents by vim.NIL.
local function without_nulls(object)
  for name, value in pairs(object) do
    if value == vim.NIL then
      object[name] = nil
    end
  end
  return object
end

--- The buffer of the program that plays, if it is open.
local function buffer_of(client, uri)
  for buffer in pairs(client.attached_buffers) do
    if vim.api.nvim_buf_is_loaded(buffer) and vim.uri_from_bufnr(buffer) == uri then
      return buffer
    end
  end
end

--- Mark the words that the server reported. Returns false if the text has changed meanwhile.
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

--- Ask the server what plays from a beat on.
local function ask(client, buffer, beat)
  server.request(client, "improv/moments", { beat = beat }, function(_, told)
    if told and told.ranges and is_active(players[client.id]) then
      take(client, told, beat) -- if the text has changed, we ask again after the next message
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

--- `improv/evaluated`: a saved program has taken over.
function M.evaluated(id, told)
  local client = vim.lsp.get_client_by_id(id)
  if client and not take(client, told, told.from) then
    ask(client, buffer_of(client, told.uri), told.from)
  end
end

--- Which robots are muted or soloed, in words.
local function silenced(transport)
  local muted, soloed = transport.muted or {}, transport.soloed or {}
  if #soloed > 0 then
    return "only " .. table.concat(soloed, ", ") .. " may move"
  end
  return #muted > 0 and table.concat(muted, ", ") .. " muted" or "all robots may move"
end

--- `improv/transport`: the state of playback.
function M.transport(id, told)
  local client, player = vim.lsp.get_client_by_id(id), player_of(id)
  if silenced(told) ~= silenced(player.transport or {}) then
    vim.notify(silenced(told))
  end
  player.transport, player.heard, player.shown = without_nulls(told), seconds() - age(told.wall), nil
  for generation in pairs(player.words) do
    if generation < told.generation or not (is_active(player) or told.state == "waiting") then
      drop(player, generation)
    end
  end
  show(player)
  local buffer = client and told.uri and buffer_of(client, told.uri)
  local beat = beat_of(player)
  local known = is_known(player.words[told.generation], beat, beat + AHEAD * told.tempo / 60)
  if buffer and is_active(player) and not known then
    ask(client, buffer, beat)
  end
end

--- The state of playback, in one line.
function M.status(id)
  local player = players[id]
  local told = player and player.transport
  if not told then
    return "Improv"
  end
  player.watched = true
  if told.state == "waiting" then
    return ("… waiting for robots, %s"):format(told.backend)
  elseif not is_active(player) then
    return ("■ %s"):format(told.state)
  end
  local sign = told.state == "playing" and "▶" or "‖"
  local whole = told.beats and math.max(math.ceil(told.beats), 1)
  local beat = math.min(math.floor(beat_of(player)) + 1, whole or math.huge)
  return ("%s beat %d/%s, %g bpm, %s"):format(sign, beat, whole or "∞", told.tempo, told.backend)
end

--- The last transport of a server, or an empty table.
function M.transport_of(id)
  return players[id] and players[id].transport or {}
end

--- The robots in the programs that play.
function M.robots(id)
  local found = {}
  for _, each in pairs(words_of(id)) do
    vim.list_extend(found, vim.tbl_keys(each.robots))
  end
  table.sort(found)
  return vim.fn.uniq(found)
end

--- Remove the highlights of a server from a buffer that it no longer serves.
function M.leave(id, buffer)
  for generation, each in pairs(words_of(id)) do
    if each.buffer == buffer then
      drop(players[id], generation)
    end
  end
end

--- Remove everything of a server that has ended.
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
