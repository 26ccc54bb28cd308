-- How an Improv program is written: comments, and colors by the tree-sitter grammar where there is one.

vim.bo.commentstring = "# %s"
vim.bo.comments = ":#"
vim.b.undo_ftplugin = "setlocal commentstring< comments<"

-- Without a grammar, syntax/improv.vim colors the words until the server does.
local found, queries = pcall(vim.treesitter.query.get, "improv", "highlights")
if found and queries and pcall(vim.treesitter.start, 0, "improv") then
  vim.b.undo_ftplugin = vim.b.undo_ftplugin .. " | lua vim.treesitter.stop()"
end
