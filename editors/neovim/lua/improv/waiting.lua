-- Programs that are to play once their server has started: what is saved or played before that would be lost.

local server = require("improv.server")

local M = {}

local programs = {} -- by buffer, what the server is to play

--- Play a program as soon as its server has started. Returns false if no server is starting.
function M.play(buffer, arguments)
  if not server.is_starting() then
    return false
  end
  programs[buffer] = arguments
  vim.notify("Improv is starting; then this program plays")
  return true
end

--- A save: the server hears of it itself, unless it is still starting.
function M.saved(buffer, settings)
  if not server.of(buffer) and (settings or {}).onSave ~= "off" then
    M.play(buffer, { vim.uri_from_bufnr(buffer) })
  end
end

--- The server of a buffer has started, and has its text.
function M.attached(client, buffer)
  local arguments = programs[buffer]
  if arguments and client.name == "improv" then
    programs[buffer] = nil
    server.execute(client, "improv.play", arguments)
  end
end

--- Play nothing of what waits.
function M.clear()
  programs = {}
end

return M
