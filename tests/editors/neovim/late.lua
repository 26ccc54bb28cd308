-- A person who saves, plays, or stops while the server still starts; it does when the gate is opened.

local person = require("person")

local function while_it_starts(...)
  person.await("a server that starts", require("improv.server").is_starting)
  assert(#vim.lsp.get_clients { bufnr = 0 } == 0)
  for _, command in ipairs { ... } do
    vim.cmd[command]()
  end
  person.await_message("Improv is starting")
end

local function open_the_gate()
  vim.fn.writefile({ "go" }, vim.env.IMPROV_GATE)
  person.await("the server", function() return #vim.lsp.get_clients { bufnr = 0 } > 0 end)
end

--- End the server, and open the program again as it was; the next server starts.
local function start_again()
  vim.fn.delete(vim.env.IMPROV_GATE)
  vim.lsp.stop_client(vim.lsp.get_clients({ bufnr = 0 })[1].id)
  person.await("the end", function() return #vim.lsp.get_clients { bufnr = 0 } == 0 end)
  person.await("the end of the dance", function() return require("improv").statusline() == "" end)
  vim.cmd.messages("clear")
  vim.cmd.edit { bang = true }
end

person.session(function()
  while_it_starts("ImprovPlay")
  open_the_gate()
  person.await_status("^▶ beat %d+/∞, 60 beats/min, simulator$")

  start_again()
  while_it_starts("write", "ImprovPlay", "ImprovHush")
  open_the_gate()
  vim.cmd.ImprovSeek("three")
  person.await_message("improv.seek: expected a beat")
  assert(not vim.fn.execute("messages"):find("▶"))
end)
