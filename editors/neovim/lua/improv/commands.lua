-- The commands of a buffer with an Improv program; docs/settings.md describes each.

local playing = require("improv.playing")
local server = require("improv.server")
local waiting = require("improv.waiting")

local M = {}

--- The server of this buffer, or nil and a warning.
local function here()
  local client = server.of(0)
  if not client then
    vim.notify("Improv's language server is not running here; `:checkhealth improv` shows why", vim.log.levels.WARN)
  end
  return client
end

local function execute(command, arguments)
  local client = here()
  if client then
    server.execute(client, command, arguments)
  end
end

--- A number; the server reports what is wrong with any other text.
local function number(text)
  return { tonumber(text) or text }
end

local function play()
  local buffer = vim.api.nvim_get_current_buf()
  if server.of(buffer) or not waiting.play(buffer) then
    execute("improv.play", { vim.uri_from_bufnr(buffer) })
  end
end

local function hush()
  waiting.clear()
  for _, client in ipairs(vim.lsp.get_clients { name = "improv" }) do
    server.execute(client, "improv.hush")
  end
end

local function robots(typed)
  local client = server.of(0)
  return vim.tbl_filter(function(name)
    return vim.startswith(name, typed)
  end, client and playing.robots(client.id) or {})
end

local function with_argument(command)
  return function(given) execute(command, { given.args }) end
end

--- Define the commands in a buffer, and :ImprovHush everywhere: robots must stop from any buffer.
function M.define(buffer)
  local function command(name, act, description, options)
    options = vim.tbl_extend("error", { desc = description }, options or {})
    vim.api.nvim_buf_create_user_command(buffer, name, act, options)
  end
  local a_number, a_robot = { nargs = 1 }, { nargs = 1, complete = robots }

  command("ImprovPlay", play, "Play this program")
  command("ImprovPause", function() execute("improv.pause") end, "Pause all robots")
  command("ImprovResume", function() execute("improv.resume") end, "Resume after a pause")
  command("ImprovCue", function() execute("improv.cue") end, "Give the cue that robots wait for")
  command("ImprovKey", with_argument("improv.key"), "Hold the key of a sense, or release it", { nargs = 1 })
  command("ImprovRestart", function() execute("improv.restart") end, "Play the current program from the beginning")
  command("ImprovSeek", function(given) execute("improv.seek", number(given.args)) end, "Go to a beat", a_number)
  command("ImprovSpeed", function(given) execute("improv.speed", number(given.args)) end, "Set the speed", a_number)
  command("ImprovMute", with_argument("improv.mute"), "Mute or unmute a robot", a_robot)
  command("ImprovSolo", with_argument("improv.solo"), "Play only this robot, or all robots again", a_robot)
  command("ImprovPage", function() execute("improv.page") end, "Show the robots in the browser")
  vim.api.nvim_create_user_command("ImprovHush", hush, { desc = "Stop all robots immediately" })
end

return M
