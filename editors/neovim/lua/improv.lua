-- Improv in Neovim: starts the language server for *.improv files, and gives its commands names.

local M = {}

--- The folder of the nearest improv.toml, else the file's own: files that share it share a server and a stage.
local function root_of(buffer)
  return vim.fs.root(buffer, "improv.toml") or vim.fs.dirname(vim.api.nvim_buf_get_name(buffer))
end

local function execute(client, command, arguments)
  local params = { command = command, arguments = arguments }
  local function answered(problem)
    if problem then
      vim.notify(problem.message, vim.log.levels.ERROR)
    end
  end
  if vim.fn.has("nvim-0.11") == 1 then
    client:request("workspace/executeCommand", params, answered)
  else
    client.request("workspace/executeCommand", params, answered)
  end
end

--- Play this buffer as it is now, saved or not.
function M.play()
  local client = vim.lsp.get_clients({ name = "improv", bufnr = 0 })[1]
  if client then
    execute(client, "improv.play", { vim.uri_from_bufnr(0) })
  else
    vim.notify("Improv's server is not at work in this buffer", vim.log.levels.WARN)
  end
end

--- Stop every robot at once, from whichever buffer.
function M.hush()
  for _, client in ipairs(vim.lsp.get_clients { name = "improv" }) do
    execute(client, "improv.hush")
  end
end

--- `cmd` starts the server; `settings` are those of docs/settings.md, such as { backend = "sim" }.
function M.setup(options)
  options = options or {}
  local settings = { improv = options.settings }
  local config = {
    cmd = options.cmd or { "improv-ls" },
    filetypes = { "improv" },
    init_options = settings, -- known before the first file is opened
    settings = settings, -- given again when the server asks
  }

  local opened -- what an opened file needs of us
  if vim.fn.has("nvim-0.11") == 1 then
    config.root_dir = function(buffer, start)
      start(root_of(buffer))
    end
    vim.lsp.config("improv", config)
    vim.lsp.enable("improv")
    opened = function()
      if vim.fn.executable(config.cmd[1]) == 0 then -- Neovim itself would only log it
        vim.notify_once(config.cmd[1] .. " is not found: install Improv, or give setup() a cmd", vim.log.levels.WARN)
      end
    end
  else
    opened = function(event)
      local here = { name = "improv", root_dir = root_of(event.buf) }
      vim.lsp.start(vim.tbl_extend("error", here, config), { bufnr = event.buf })
    end
  end
  local group = vim.api.nvim_create_augroup("improv", {})
  vim.api.nvim_create_autocmd("FileType", { pattern = config.filetypes, group = group, callback = opened })

  vim.api.nvim_create_user_command("ImprovPlay", M.play, { desc = "Play this file" })
  vim.api.nvim_create_user_command("ImprovHush", M.hush, { desc = "Stop the robots" })
end

return M
