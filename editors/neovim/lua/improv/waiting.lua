-- What is to happen once the server of a program has started: what is saved or played before that would be lost.

local server = require("improv.server")

local M = {}

local wishes = {} -- by buffer: the text that was saved, or the arguments of `improv.play`

--- Do this as soon as the server of the buffer has started. Starts it if need be. Returns false if none starts.
local function wait(buffer, wish)
  if not server.is_starting() and not server.start(buffer) then
    return false
  end
  wishes[buffer] = wish
  server.say("Improv is starting; then this program plays")
  return true
end

--- Play a program as soon as its server has started. Returns false if no server starts.
function M.play(buffer, arguments)
  return wait(buffer, { arguments = arguments })
end

--- The text of a buffer, as it was just saved.
local function text_of(buffer)
  local line_end = ({ dos = "\r\n", mac = "\r" })[vim.bo[buffer].fileformat] or "\n"
  local lines = vim.api.nvim_buf_get_lines(buffer, 0, -1, false)
  return table.concat(lines, line_end) .. (vim.bo[buffer].endofline and line_end or "")
end

--- A save: the server hears of it itself, if it runs.
function M.saved(buffer, settings)
  if server.of(buffer) or (settings or {}).onSave == "off" then
    return
  end
  if not wait(buffer, { saved = text_of(buffer) }) then
    server.say("Improv's server is not running: see `:checkhealth improv`", "WarningMsg")
  end
end

--- The server of a buffer has started, and has the text as it is now. But what was saved is what plays.
function M.attached(client, buffer)
  local wish = client.name == "improv" and wishes[buffer]
  if not wish then
    return
  end
  wishes[buffer] = nil
  if wish.saved then
    local document = { uri = vim.uri_from_bufnr(buffer) }
    server.notify(client, "textDocument/didSave", { textDocument = document, text = wish.saved })
  else
    server.execute(client, "improv.play", wish.arguments)
  end
end

--- Do nothing of what waits.
function M.clear()
  wishes = {}
end

return M
