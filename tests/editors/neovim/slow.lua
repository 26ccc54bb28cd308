-- A person who saves, plays, or stops while the server still starts; it does when the gate is opened.

local person = dofile(vim.env.IMPROV_PERSON)

person.session(function()
  person.await("a server that starts", require("improv.server").is_starting)
  assert(#vim.lsp.get_clients { bufnr = 0 } == 0)
  for _, command in ipairs(vim.split(vim.env.IMPROV_STEPS, " ")) do
    vim.cmd[command]()
  end
  person.await_message("Improv is starting")
  vim.fn.writefile({ "go" }, vim.env.IMPROV_GATE)
  person.await("the server", function() return #vim.lsp.get_clients { bufnr = 0 } > 0 end)
  if not vim.env.IMPROV_STEPS:find("Hush") then
    person.await_status("^▶ beat %d+/∞, 60 bpm, simulator$")
    person.await("the page", function() return vim.g.page end)
    person.robot("moves")
    return
  end
  vim.cmd.ImprovSeek("three")
  person.await_message("improv.seek: expected a beat")
  assert(not vim.fn.execute("messages"):find("▶"))
end)
