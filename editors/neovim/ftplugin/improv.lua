-- Comments of Improv programs, and colors from the tree-sitter grammar if it is installed.

vim.bo.commentstring = "# %s"
vim.bo.comments = ":#"
vim.b.undo_ftplugin = "setlocal commentstring< comments< signcolumn<"

-- With `auto`, all text would move when the first error comes, and when the last one goes.
if vim.o.signcolumn == "auto" then
  vim.wo[0][0].signcolumn = "yes"
end

-- Without the grammar, syntax/improv.vim colors the words until the server does.
local found, queries = pcall(vim.treesitter.query.get, "improv", "highlights")
if found and queries and pcall(vim.treesitter.start, 0, "improv") then
  vim.b.undo_ftplugin = vim.b.undo_ftplugin .. " | lua vim.treesitter.stop()"
end
