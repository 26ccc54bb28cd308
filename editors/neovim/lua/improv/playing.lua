-- What plays, as the server tells it whenever it changes: it highlights words, and updates the status line.

local words = require("improv.words")

local M = {}

-- For each server: the last `transport`, and what is `lit` in which `buffer`. Only the server's messages create an
-- entry, because a status line may still be drawn for a server that has ended.
local players = {}

local function player_of(id)
  players[id] = players[id] or { watched = true }
  return players[id]
end

local function darken(player)
  if player.buffer then
    words.darken(player.buffer)
  end
  player.buffer, player.lit = nil, nil
end

--- The buffer of a program that the client serves, if it is open.
local function buffer_of(client, uri)
  for buffer in pairs(client.attached_buffers) do
    if vim.api.nvim_buf_is_loaded(buffer) and vim.uri_from_bufnr(buffer) == uri then
      return buffer
    end
  end
end

--- Highlight what is lit. Who types is ahead of the server: until it has caught up, highlights move with the text.
local function light(client, player)
  if vim.g.improv_playing == false then
    words.darken(player.buffer)
  elseif vim.lsp.util.buf_versions[player.buffer] == player.lit.version then
    words.light(player.buffer, client.offset_encoding, player.lit.ranges)
  end
end

--- `improv/lit`: which words are lit from now on.
function M.lit(id, told)
  local client, player = vim.lsp.get_client_by_id(id), player_of(id)
  local buffer = client and buffer_of(client, told.uri)
  if #told.ranges == 0 or buffer ~= player.buffer then
    darken(player)
  end
  if buffer and #told.ranges > 0 then
    player.buffer, player.lit = buffer, told
    light(client, player)
  end
end

--- `improv/evaluated`: what was just played.
function M.evaluated(id, told)
  local client = vim.lsp.get_client_by_id(id)
  local buffer = client and buffer_of(client, told.uri)
  if buffer and vim.lsp.util.buf_versions[buffer] == told.version then
    words.flash(buffer, client.offset_encoding, told.range)
  end
end

--- `improv/transport`: the state of playback, at every change and at every beat.
function M.transport(id, told)
  local client, player = vim.lsp.get_client_by_id(id), player_of(id)
  if told.silenced ~= (player.transport or { silenced = "" }).silenced then
    vim.notify(told.silenced ~= "" and told.silenced or "all robots may move")
  end
  player.transport = told
  if client and player.buffer then
    light(client, player) -- the text, or `g:improv_playing`, may have changed
  end
  if player.watched then
    player.watched = false
    vim.cmd.redrawstatus { bang = true }
  end
end

--- The state of playback, in one line. Beats count from 1.
function M.status(id)
  local player = players[id]
  local told = player and player.transport
  if not told then
    return "Improv"
  end
  player.watched = true
  if told.state == "waiting" then
    return ("… waiting for robots, %s"):format(told.backend)
  elseif told.state ~= "playing" and told.state ~= "paused" then
    return ("■ %s"):format(told.state)
  end
  local sign = told.state == "playing" and "▶" or "‖"
  local silenced = told.silenced ~= "" and ", " .. told.silenced or ""
  return ("%s %s, %g beats/min, %s%s"):format(sign, told.counted, told.tempo, told.backend, silenced)
end

--- The last transport of a server, or an empty table.
function M.transport_of(id)
  return players[id] and players[id].transport or {}
end

--- Remove the highlights of a server from a buffer that it no longer serves.
function M.leave(id, buffer)
  if players[id] and players[id].buffer == buffer then
    darken(players[id])
  end
end

--- Remove everything of a server that has ended.
function M.forget(id)
  if players[id] then
    darken(players[id])
    players[id] = nil
    vim.cmd.redrawstatus { bang = true }
  end
end

return M
