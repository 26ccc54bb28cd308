-- Who uses a name, all safe fixes at once, the beat of the line that plays, and whom robots meet.

local person = require("person")
local await = person.await

local function ask(method, params)
  local client = vim.lsp.get_clients({ bufnr = 0 })[1]
  return vim.lsp.buf_request_sync(0, method, params, person.LIMIT)[client.id].result
end

local function hint()
  local found = vim.lsp.inlay_hint.get({ bufnr = 0 })[1]
  return found and found.inlay_hint.label or ""
end

person.session(function()
  person.open("beat 120", "x = forward, left", "turtle1 $ repeat x")
  await("the error", function() return (vim.diagnostic.get(0)[1] or {}).lnum == 1 end)
  vim.lsp.buf.code_action({ context = { only = { "source.fixAll.improv" }, diagnostics = {} }, apply = true })
  await("the fix", function() return vim.fn.getline(2) == "x = forward left" end)

  local client = vim.lsp.get_clients({ bufnr = 0 })[1]
  vim.fn.cursor(2, 1)
  local here = vim.lsp.util.make_position_params(0, client.offset_encoding)
  local item = ask("textDocument/prepareCallHierarchy", here)[1]
  local callers = ask("callHierarchy/incomingCalls", { item = item })
  assert(#callers == 1 and callers[1].from.name == "turtle1", vim.inspect(callers))

  vim.lsp.buf_notify(0, "workspace/didChangeConfiguration", { settings = { improv = { inlayHints = { playing = true } } } })
  vim.lsp.inlay_hint.enable(true, { bufnr = 0 })
  vim.cmd.write()
  await("the first beats", function() return hint():find("^beat %d+/∞$") end)
  local first = hint()
  await("the next beat", function() return hint():find("^beat %d+/∞$") and hint() ~= first end)
  vim.cmd.ImprovHush()
  await("no beat", function() return hint() == "" end)

  -- The server finds this out after it has answered, and nobody types meanwhile.
  vim.api.nvim_buf_set_lines(0, 0, -1, false, { "ada at 0 0", "bo at 1 -1 facing 90", "ada $ forward", "bo $ forward" })
  await("a meeting", function() return (vim.diagnostic.get(0)[1] or {}).code == "meets" end)
end)
