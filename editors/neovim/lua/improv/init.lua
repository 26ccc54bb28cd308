-- Improv in Neovim: `setup` for init.lua, and `statusline`. The help has all of it: `:help improv`.

local M = {}

--- Start the server for *.improv files. `cmd` is what starts it; `settings` are those of the server, such as
--- { backend = "sim" }.
function M.setup(options)
  options = vim.tbl_extend("keep", options or {}, { cmd = { "improv-ls" } })
  vim.api.nvim_set_hl(0, "ImprovPlaying", { default = true, link = "IncSearch" })
  local server = require("improv.server")
  server.cmd = options.cmd

  local function opened(buffer)
    if vim.fn.executable(options.cmd[1]) == 0 then -- Neovim itself would only log it
      vim.notify_once(options.cmd[1] .. " is not found: install Improv, or give setup() a cmd", vim.log.levels.WARN)
    end
    require("improv.commands").define(buffer)
  end

  local group = vim.api.nvim_create_augroup("improv", {})
  local function on(event, pattern, act)
    vim.api.nvim_create_autocmd(event, { group = group, pattern = pattern, callback = act })
  end
  on("FileType", "improv", function(event) opened(event.buf) end)
  on("LspDetach", nil, function(event) require("improv.playing").leave(event.data.client_id, event.buf) end)
  server.enable(group, options.settings)
  vim.cmd.doautoall("<nomodeline> improv FileType") -- for files opened before
end

--- What plays, for the status line: `▶ beat 3/8, 120 bpm, simulator`. Empty where there is no server.
function M.statusline()
  local client = require("improv.server").of(0)
  return client and require("improv.playing").status(client.id) or ""
end

return M
