-- A user's init.lua, as editors/neovim/README.md has it, with the server of the environment under test.
vim.opt.runtimepath:prepend(vim.env.IMPROV_PLUGIN)
require("improv").setup {
  cmd = vim.env.IMPROV_SLOW and { vim.env.IMPROV_SLOW } or { vim.env.IMPROV_PYTHON, "-m", "improv_ls" },
  settings = { backend = "sim" },
}
vim.o.laststatus = 2
vim.o.statusline = "%f  %{v:lua.require'improv'.statusline()}"

-- The person's browser: it only notes the address.
vim.ui.open = function(url)
  vim.g.page = url
  vim.fn.writefile({ url }, vim.env.IMPROV_PAGE)
  return { wait = function() return { code = 0 } end }
end
