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

--- Play this program, or what `some` lists for the server: a range, a name, or two lines. Others dance on unless `alone`.
local function play(some, alone)
  local buffer = vim.api.nvim_get_current_buf()
  local arguments = { vim.uri_from_bufnr(buffer), unpack(some) }
  if server.of(buffer) or not waiting.play(buffer, arguments) then
    execute(alone and #some > 0 and "improv.only" or "improv.play", arguments)
  end
end

--- What was selected, between two positions as getpos() returns them: whole lines unless it was by characters.
local function selected(mode, from, to)
  local first, last = { from[2], from[3] - 1 }, { to[2], to[3] - 1 }
  if first[1] > last[1] or (first[1] == last[1] and first[2] > last[2]) then
    first, last = last, first
  end
  local client = server.of(0)
  if mode ~= "v" or not client then
    return { first[1], last[1] }
  end
  return { vim.lsp.util.make_given_range_params(first, last, 0, client.offset_encoding).range }
end

local function command_play(given)
  if given.range == 0 then
    return play(given.args ~= "" and { given.args } or {}, given.bang)
  end
  local from, to = vim.fn.getpos("'<"), vim.fn.getpos("'>")
  local is_visual = given.range == 2 and given.line1 == from[2] and given.line2 == to[2]
  play(is_visual and selected(vim.fn.visualmode(), from, to) or { given.line1, given.line2 }, given.bang)
end

--- Play the selection, or else the line of the cursor.
local function play_this()
  local mode = vim.fn.mode()
  local is_visual = mode:find("[vV\22]") ~= nil
  play(selected(mode, vim.fn.getpos(is_visual and "v" or "."), vim.fn.getpos(".")))
  if is_visual then
    vim.cmd.normal { "\27", bang = true }
  end
end

local function before()
  execute("improv.before", { vim.uri_from_bufnr(vim.api.nvim_get_current_buf()) })
end

--- Show a text in a window of its own, to read and to copy from.
local function show(text)
  vim.cmd.new()
  vim.api.nvim_buf_set_lines(0, 0, -1, false, vim.split(text, "\r?\n"))
  vim.bo.buftype, vim.bo.bufhidden, vim.bo.syntax, vim.bo.modifiable = "nofile", "wipe", "improv", false
end

--- Choose one of the programs that played, and show it.
local function history()
  local client = here()
  if not client then
    return
  end
  server.execute(client, "improv.history", {}, function(programs)
    if #programs == 0 then
      return vim.notify("Nothing has played yet")
    end
    local function line(each) return ("%s  %s  %s"):format(each.played, each.name, each.line) end
    vim.ui.select(programs, { prompt = "Programs that played", format_item = line }, function(chosen)
      if chosen then
        server.execute(client, "improv.history", { chosen.id }, function(text)
          if type(text) == "string" then show(text) end
        end)
      end
    end)
  end)
end

--- Insert the program for the paths in a recording or a drawing below the cursor.
local function transcribe(given)
  local client = here()
  if not client then
    return
  end
  local file = vim.fn.fnamemodify(given.args, ":p")
  server.execute(client, "improv.transcribe", { file }, function(text)
    if type(text) == "string" then vim.api.nvim_put(vim.split(vim.trim(text), "\n"), "l", true, false) end
  end)
end

local function stop()
  waiting.clear()
  for _, client in ipairs(vim.lsp.get_clients { name = "improv" }) do
    server.execute(client, "improv.stop")
  end
end

local function robots(typed)
  local client = server.of(0)
  return vim.tbl_filter(function(name)
    return vim.startswith(name, typed)
  end, client and playing.transport_of(client.id).robots or {})
end

local function with_argument(command)
  return function(given) execute(command, { given.args }) end
end

--- Define the commands in a buffer, and :ImprovStop everywhere: robots must stop from any buffer.
function M.define(buffer)
  local function command(name, act, description, options)
    options = vim.tbl_extend("error", { desc = description }, options or {})
    vim.api.nvim_buf_create_user_command(buffer, name, act, options)
  end
  local a_number, a_robot = { nargs = 1 }, { nargs = 1, complete = robots }

  local some = { nargs = "?", range = true, bang = true }
  command("ImprovPlay", command_play, "Play this program, or these lines or this name; with !, only these", some)
  command("ImprovBefore", before, "Play the version of this program that played before")
  command("ImprovHistory", history, "Show a program that played")
  command("ImprovTranscribe", transcribe, "Insert the words for a recording", { nargs = 1, complete = "file" })
  command("ImprovPause", function() execute("improv.pause") end, "Pause all robots")
  command("ImprovResume", function() execute("improv.resume") end, "Resume after a pause")
  command("ImprovAnyway", function() execute("improv.anyway") end, "Begin although robots are not in their places")
  command("ImprovCue", function() execute("improv.cue") end, "Give the cue that robots wait for")
  command("ImprovKey", with_argument("improv.key"), "Hold the key of a sense, or release it", { nargs = 1 })
  command("ImprovRestart", function() execute("improv.restart") end, "Play the current program from the beginning")
  command("ImprovSeek", function(given) execute("improv.seek", number(given.args)) end, "Go to a beat", a_number)
  command("ImprovSpeed", function(given) execute("improv.speed", number(given.args)) end, "Set the speed", a_number)
  command("ImprovMute", with_argument("improv.mute"), "Mute or unmute a robot", a_robot)
  command("ImprovSolo", with_argument("improv.solo"), "Play only this robot, or all robots again", a_robot)
  command("ImprovPage", function() execute("improv.page") end, "Show the robots in the browser")
  command("ImprovCalibrate", function() execute("improv.calibrate") end, "Show how to calibrate a robot")
  for _, name in ipairs { "ImprovStop", "ImprovHush" } do -- the second is its earlier name
    vim.api.nvim_create_user_command(name, stop, { desc = "Stop all robots immediately" })
  end
  local mapping = { buffer = buffer, desc = "Improv: play this line or selection" }
  vim.keymap.set({ "n", "x" }, "<Plug>(improv-play-this)", play_this, mapping)
  if not vim.g.no_plugin_maps and not vim.g.no_improv_maps and vim.fn.hasmapto("<Plug>(improv-play-this)") == 0 then
    vim.keymap.set({ "n", "x" }, "<LocalLeader><CR>", "<Plug>(improv-play-this)", mapping)
  end
end

return M
