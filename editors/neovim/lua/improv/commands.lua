-- The commands of a buffer with an Improv program: docs/settings.md says what each does.

local playing = require("improv.playing")
local server = require("improv.server")

local M = {}

--- The server of this buffer, or a line that says there is none.
local function here()
  local client = server.of(0)
  if not client then
    vim.notify("Improv's server is not at work in this buffer: `:checkhealth improv` says why", vim.log.levels.WARN)
  end
  return client
end

local function conduct(command, arguments)
  local client = here()
  if client then
    server.execute(client, command, arguments)
  end
end

--- A number, as people write it; the server says what is wrong with another text.
local function number(text)
  return { tonumber(text) or text }
end

local function hush()
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

local function of_robot(command)
  return function(given) conduct(command, { given.args }) end
end

--- Define them in a buffer of ours; :ImprovHush everywhere, as robots are to stop from wherever one is.
function M.define(buffer)
  local function command(name, act, about, options)
    options = vim.tbl_extend("error", { desc = about }, options or {})
    vim.api.nvim_buf_create_user_command(buffer, name, act, options)
  end
  local a_number, a_robot = { nargs = 1 }, { nargs = 1, complete = robots }

  command("ImprovPlay", function() conduct("improv.play", { vim.uri_from_bufnr(0) }) end, "Play this file from beat 0")
  command("ImprovPause", function() conduct("improv.pause") end, "Stop the robots, to go on from there")
  command("ImprovResume", function() conduct("improv.resume") end, "Go on after a pause")
  command("ImprovRestart", function() conduct("improv.restart") end, "Play from beat 0 what plays")
  command("ImprovSeek", function(given) conduct("improv.seek", number(given.args)) end, "Go on from a beat", a_number)
  command("ImprovSpeed", function(given) conduct("improv.speed", number(given.args)) end, "Change the speed", a_number)
  command("ImprovMute", of_robot("improv.mute"), "Have a robot stand still, or end that", a_robot)
  command("ImprovSolo", of_robot("improv.solo"), "Have all other robots stand still, or end that", a_robot)
  command("ImprovPage", function() conduct("improv.page") end, "Show the robots in the browser")
  vim.api.nvim_create_user_command("ImprovHush", hush, { desc = "Stop every robot at once" })
end

return M
