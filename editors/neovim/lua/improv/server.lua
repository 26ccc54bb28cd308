-- The language server: start it, send requests and handle its messages, in Neovim 0.10 and newer.

local M = { cmd = { "improv-ls" } }

local MAX_STARTS = 4 -- how often servers are started again within `RECENTLY`: then something is wrong with them
local RECENTLY = 180 -- seconds
local SIGTERM = 15 -- by which Neovim stops a server that does not end when it is asked to

local starting = 0 -- how many servers have been started and have not answered yet
local answered = {} -- which connections to servers work
local started_again = {} -- when, in seconds
local config -- of the client

local NEW = vim.fn.has("nvim-0.11") == 1

--- The server of a buffer; 0 is the current buffer.
function M.of(buffer)
  return vim.lsp.get_clients({ name = "improv", bufnr = buffer })[1]
end

--- Whether a server has been started and can't be asked anything yet.
function M.is_starting()
  return starting > 0
end

--- Show one line, without a prompt even if another line was shown just before. `highlight` is a highlight group.
function M.say(line, highlight)
  vim.schedule(function()
    vim.cmd.redraw() -- now this line replaces the one before, and does not come below it
    if vim.fn.strdisplaywidth(line) <= vim.v.echospace then
      return vim.api.nvim_echo({ { line, highlight } }, true, {})
    end
    vim.cmd.echohl(highlight or "None") -- Neovim shortens it; `:messages` shows all of it
    vim.cmd.echomsg(vim.fn.string(line))
    vim.cmd.echohl("None")
  end)
end

--- Send a notification.
function M.notify(client, method, params)
  if NEW then
    client:notify(method, params)
  else
    client.notify(method, params)
  end
end

--- Send a request about a buffer. The server first receives everything that was typed there.
function M.request(client, method, params, handler, buffer)
  if NEW then
    client:request(method, params, handler, buffer)
  else
    client.request(method, params, handler, buffer)
  end
end

--- Have the server execute a command, and show an error in one line. `take` gets the result, if it is given.
function M.execute(client, command, arguments, take)
  local offered = vim.tbl_get(client.server_capabilities, "executeCommandProvider", "commands") or {}
  if not vim.tbl_contains(offered, command) then
    return vim.notify("This improv-ls does not support " .. command .. "; install a newer one", vim.log.levels.WARN)
  end
  M.request(client, "workspace/executeCommand", { command = command, arguments = arguments }, function(problem, result)
    if problem then
      vim.notify(problem.message, vim.log.levels.ERROR)
    elseif take then
      take(result)
    elseif type(result) == "string" then
      vim.notify("The robots are at " .. result) -- the browser may not have opened
    end
  end)
end

--- Whether the server is for a buffer: it is a program, or an improv.toml, but no other TOML file.
local function is_ours(buffer)
  local name = vim.fs.basename(vim.api.nvim_buf_get_name(buffer))
  return vim.bo[buffer].filetype == "improv" or name == "improv.toml"
end

--- The folder of the nearest improv.toml, or the file's own. Files that share it share a server and a stage.
local function root_of(buffer)
  local name = vim.api.nvim_buf_get_name(buffer)
  return vim.fs.root(buffer, "improv.toml") or (name == "" and vim.fn.getcwd() or vim.fs.dirname(name))
end

--- Show a message from the server in one line, without a prompt.
local function show_message(_, params)
  local line = params.message:gsub("%s*[\r\n]+%s*", " ")
  if vim.fn.strdisplaywidth(line) <= vim.v.echospace then
    vim.notify(line, vim.log.levels.ERROR + 1 - params.type)
  else -- Neovim shortens it; `:messages` shows all of it
    vim.cmd.echohl(params.type == vim.lsp.protocol.MessageType.Error and "ErrorMsg" or "WarningMsg")
    vim.cmd.echomsg(vim.fn.string(line))
    vim.cmd.echohl("None")
  end
end

--- The open programs, and improv.toml files, that have no server.
local function unserved()
  return vim.tbl_filter(function(buffer)
    return vim.api.nvim_buf_is_loaded(buffer) and is_ours(buffer) and not M.of(buffer)
  end, vim.api.nvim_list_bufs())
end

--- Start the server of a buffer, if it has none. Returns whether one is starting then.
function M.start(buffer)
  if is_ours(buffer) and vim.fn.executable(M.cmd[1]) == 1 then
    local here = { name = "improv", root_dir = root_of(buffer) }
    vim.lsp.start(vim.tbl_extend("force", NEW and vim.lsp.config.improv or config, here), { bufnr = buffer })
  end
  return M.is_starting()
end

--- A server has ended that nobody has stopped. Start it again for the buffers it served, if it ever `answered`.
local function lost(answered)
  if not answered then
    return M.say("Improv's server does not start: see `:checkhealth improv`", "WarningMsg")
  end
  local now = vim.uv.hrtime() / 1e9
  started_again = vim.tbl_filter(function(time) return now - time < RECENTLY end, started_again)
  if #started_again == MAX_STARTS then
    return M.say("Improv's server keeps ending and stays off: save to start it", "WarningMsg")
  end
  table.insert(started_again, now)
  vim.tbl_map(M.start, unserved())
  M.say("Improv's server ended, and the robots stopped: save to play", "WarningMsg")
end

--- Run the server. It counts as starting until it has answered.
local function run(dispatchers)
  local rpc
  local ended = dispatchers.on_exit
  dispatchers.on_exit = function(code, signal)
    ended(0, 0) -- Neovim would report a lost server in a line so long that it asks for ENTER; we report it
    vim.schedule(function() -- Neovim has detached the buffers
      vim.schedule(function() -- and forgotten the client
        if not answered[rpc] then
          starting = starting - 1
          require("improv.waiting").clear()
        end
        if code ~= 0 or (signal ~= 0 and signal ~= SIGTERM) then
          lost(answered[rpc])
        end
        answered[rpc] = nil
      end)
    end)
  end
  rpc = vim.lsp.rpc.start(M.cmd, dispatchers)
  starting = starting + 1
  return rpc
end

--- Start a server for the programs and the improv.toml in each folder.
function M.enable(group, settings)
  local playing = require("improv.playing")
  config = {
    cmd = run,
    filetypes = { "improv", "toml" },
    capabilities = { experimental = { improv = true } }, -- we highlight the words that play
    init_options = { improv = settings }, -- needed before the first file opens
    settings = { improv = settings }, -- for when the server asks
    handlers = {
      ["improv/lit"] = function(_, params, context) playing.lit(context.client_id, params) end,
      ["improv/evaluated"] = function(_, params, context) playing.evaluated(context.client_id, params) end,
      ["improv/transport"] = function(_, params, context) playing.transport(context.client_id, params) end,
      ["window/showMessage"] = show_message,
    },
    on_init = function(client)
      starting, answered[client.rpc] = starting - 1, true
    end,
    on_exit = vim.schedule_wrap(function(_, _, id) playing.forget(id) end),
  }
  if NEW then
    config.root_dir = function(buffer, start)
      if is_ours(buffer) and vim.fn.executable(M.cmd[1]) == 1 then start(root_of(buffer)) end
    end
    vim.lsp.config("improv", config)
    vim.lsp.enable("improv")
    return
  end
  config.capabilities =
    vim.tbl_deep_extend("force", vim.lsp.protocol.make_client_capabilities(), config.capabilities)
  vim.api.nvim_create_autocmd("FileType", {
    group = group,
    pattern = config.filetypes,
    callback = function(event) M.start(event.buf) end,
  })
end

return M
