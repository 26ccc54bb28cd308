-- A person's session in an improv.toml with a misspelled profile; other TOML files are left alone.

local person = require("person")

person.session(function()
  local folder = vim.fs.dirname(vim.env.IMPROV_PROGRAM)
  for _, name in ipairs { "improv.toml", "other.toml" } do
    vim.fn.writefile({ "[robots.turtle1]", 'profile = "turtlebot3_burgr"', "" }, folder .. "/" .. name)
  end
  vim.cmd.edit(folder .. "/improv.toml")
  assert(vim.bo.filetype == "toml")
  person.await("the server", function() return #vim.lsp.get_clients { bufnr = 0, name = "improv" } > 0 end)
  person.await("the error", function()
    local found = vim.diagnostic.get(0)[1]
    return found and found.message:find("did you mean `turtlebot3_burger`?", 1, true)
  end)

  vim.cmd.edit(folder .. "/other.toml")
  assert(vim.bo.filetype == "toml" and #vim.lsp.get_clients { bufnr = 0, name = "improv" } == 0)
end)
