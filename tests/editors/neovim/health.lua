-- What `:checkhealth improv` and `:help improv` say; the path of what is written is in the environment.

local person = require("person")

person.session(function()
  person.open()
  vim.cmd.checkhealth("improv")
  vim.fn.writefile(vim.api.nvim_buf_get_lines(0, 0, -1, false), vim.env.IMPROV_REPORT)

  vim.cmd.helptags(vim.env.IMPROV_DOC)
  vim.opt.runtimepath:append(vim.fs.dirname(vim.env.IMPROV_DOC))
  for _, tag in ipairs { "improv", ":ImprovPlay", ":ImprovStop", ":ImprovCue", "hl-ImprovPlaying", "g:improv_playing" } do
    vim.cmd.help(tag)
    assert(vim.fn.expand("%:t") == "improv.txt", tag)
    vim.cmd.helpclose()
  end
end)
