-- Improv in Neovim: `setup` for init.lua, and `statusline`. See `:help improv`.

local M = {}

--- Start the server for *.improv files and improv.toml. `cmd` is the command that starts it; `settings` are the server's settings,
--- such as { backend = "sim" }.
function M.setup(options)
  options = vim.tbl_extend("keep", options or {}, { cmd = { "improv-ls" } })
  vim.api.nvim_set_hl(0, "ImprovPlaying", { default = true, link = "IncSearch" })
  vim.api.nvim_set_hl(0, "ImprovEvaluated", { default = true, link = "Visual" })
  local server = require("improv.server")
  server.cmd = options.cmd

  local function opened(buffer)
    if vim.fn.executable(options.cmd[1]) == 0 then -- Neovim would only log this
      vim.notify_once(options.cmd[1] .. " not found: install Improv, or pass cmd to setup()", vim.log.levels.WARN)
    end
    require("improv.commands").define(buffer)
  end

  local group = vim.api.nvim_create_augroup("improv", {})
  local function on(event, pattern, act)
    vim.api.nvim_create_autocmd(event, { group = group, pattern = pattern, callback = act })
  end
  on("FileType", "improv", function(event) opened(event.buf) end)
  local waiting = require("improv.waiting")
  on("BufWritePost", "*.improv", function(event) waiting.saved(event.buf, options.settings) end)
  on("LspAttach", nil, function(event)
    waiting.attached(assert(vim.lsp.get_client_by_id(event.data.client_id)), event.buf)
  end)
  on("LspDetach", nil, function(event) require("improv.playing").leave(event.data.client_id, event.buf) end)
  server.enable(group, options.settings)
  vim.cmd.doautoall("<nomodeline> improv FileType") -- for files that are already open
end

--- The state of playback for the status line: `▶ beat 3/8, 120 beats/min, simulator`. Empty without a server.
function M.statusline()
  local server = require("improv.server")
  local client = server.of(0)
  if client then
    return require("improv.playing").status(client.id)
  end
  return server.is_starting() and vim.bo.filetype == "improv" and "Starting Improv…" or ""
end

return M
