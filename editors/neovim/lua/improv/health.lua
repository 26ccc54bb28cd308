-- `:checkhealth improv`

local server = require("improv.server")

local M = {}

local LIMIT = 20000 -- milliseconds for the server to start, on a busy machine

local function message(content)
  local body = vim.json.encode(vim.tbl_extend("error", { jsonrpc = "2.0" }, content))
  return ("Content-Length: %d\r\n\r\n%s"):format(#body, body)
end

--- Start the server, ask for its name and version, and stop it.
local function try_server()
  local input = message { id = 1, method = "initialize", params = { capabilities = vim.empty_dict() } }
    .. message { id = 2, method = "shutdown" }
    .. message { method = "exit" }
  local done = vim.system(server.cmd, { stdin = input, timeout = LIMIT }):wait()
  local info = (done.stdout or ""):match('"serverInfo":%s*(%b{})')
  return info and vim.json.decode(info), vim.trim(done.stderr or "")
end

local function check_server()
  local path = vim.fn.exepath(server.cmd[1])
  if path == "" then
    local advice = "Install Improv and put it on your PATH, or pass `cmd` to `require('improv').setup()`"
    return vim.health.error(("`%s` not found"):format(server.cmd[1]), advice)
  end
  local info, problem = try_server()
  if info then
    vim.health.ok(("server: %s %s, `%s`"):format(info.name, info.version, path))
  else
    vim.health.error(("`%s` does not start"):format(table.concat(server.cmd, " ")), problem ~= "" and problem or nil)
  end
end

local function check_clients()
  local clients = vim.lsp.get_clients { name = "improv" }
  local open = vim.tbl_filter(function(buffer)
    return vim.api.nvim_buf_is_loaded(buffer) and vim.bo[buffer].filetype == "improv"
  end, vim.api.nvim_list_bufs())
  if #clients == 0 and #open > 0 and server.is_starting() then
    vim.health.info("the server is starting")
  elseif #clients == 0 and #open > 0 then
    vim.health.error("a program is open, but the server is not running", "Save the program: that starts the server")
  elseif #clients == 0 then
    vim.health.info("no program is open; open a file that ends in `.improv`")
  end
  for _, client in ipairs(clients) do
    local transport = require("improv.playing").transport_of(client.id)
    local plays = transport.backend and ("%s, %s"):format(transport.backend, transport.state) or "nothing played yet"
    vim.health.ok(("running in %s: %s"):format(client.config.root_dir, plays))
  end
end

local function check_colors()
  if pcall(vim.treesitter.get_string_parser, "", "improv") then
    vim.health.ok("colors: from the tree-sitter grammar and the server")
  else
    vim.health.info("colors: from `syntax/improv.vim` and the server; the tree-sitter grammar is not installed")
  end
end

function M.check()
  vim.health.start("improv")
  if vim.fn.has("nvim-0.10") == 1 then
    vim.health.ok(("Neovim %s"):format(tostring(vim.version())))
  else
    vim.health.error("Neovim is too old", "Install Neovim 0.10 or newer")
  end
  check_server()
  check_clients()
  check_colors()
end

return M
