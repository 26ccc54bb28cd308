-- The words that play, in light: they are where the text is, whatever is typed, and go out when nothing plays.

local person = require("person")
local await_lit, await_status = person.await_lit, person.await_status

local function insert(row, column, ...)
  vim.api.nvim_buf_set_text(0, row, column, row, column, { ... })
end

local function has_ended(client)
  if vim.fn.has("nvim-0.11") == 1 then
    return client:is_stopped()
  end
  return client.is_stopped()
end

person.session(function()
  person.open()

  -- 𝒹 is one letter, two units in UTF-16, four bytes in UTF-8.
  person.write("# 🤖", "𝒹 = right", "a $ repeat (𝒹 forward)", "bob $ repeat left")
  await_lit("2:8 right, 3:13 𝒹, 4:14 left")
  await_lit("3:18 forward, 4:14 left")
  await_status("^▶ beat %d+/∞, 60 beats/min, simulator$")
  vim.cmd.ImprovSpeed("2")
  await_status("^▶ beat %d+/∞, 120 beats/min, simulator$")

  -- A line flashes, and plays among the others; or only it plays, and the save brings the rest back.
  require("improv.words").FLASH = person.LIMIT
  person.break_undo()
  vim.cmd("4substitute/left/right/")
  vim.fn.cursor(4, 1)
  vim.api.nvim_feedkeys("\\\r", "x", false)
  local flashed = vim.api.nvim_get_namespaces()["improv.evaluated"]
  person.await("a flash", function()
    local mark = vim.api.nvim_buf_get_extmarks(0, flashed, 0, -1, { details = true })[1]
    return mark and mark[2] == 3 and mark[4].end_col == 18 and mark[4].hl_group == "ImprovEvaluated"
  end)
  await_lit("2:8 right, 3:13 𝒹, 4:14 right")
  vim.cmd.undo()
  vim.cmd("4ImprovPlay!")
  await_lit("4:14 left")
  vim.cmd.write()
  await_lit("2:8 right, 3:13 𝒹, 4:14 left")
  vim.fn.cursor(3, 18)
  vim.api.nvim_feedkeys("viw\\\r", "x", false)
  person.await_message("▶ line 3: a 1 beat")
  assert(vim.fn.mode() == "n", vim.fn.mode())
  vim.cmd("3ImprovPlay!")
  await_lit("2:8 right, 3:13 𝒹")
  vim.cmd.ImprovPlay { "𝒹", bang = true }
  person.await_message("▶ 𝒹: a 1 beat")
  vim.cmd.ImprovPlay("𝒷")
  person.await_message("✗ `𝒷` is not defined in this program")
  vim.cmd.write()
  await_lit("3:18 forward, 4:14 left")

  -- What is typed before a word moves its light, what is typed beside it does not widen it.
  insert(1, 0, "# 🤖", "")
  insert(4, 13, "slow 2 ")
  await_lit("3:8 right, 4:13 𝒹, 5:21 left")
  insert(3, 24, "  ")
  await_lit("4:18 forward, 5:21 left")

  -- A word that is deleted is dark; undone, it is lit.
  person.break_undo()
  vim.api.nvim_buf_set_lines(0, 2, 4, false, {})
  await_lit("3:21 left")
  vim.cmd.undo()
  await_lit("4:18 forward, 5:21 left")
  await_lit("3:8 right, 4:13 𝒹, 5:21 left")

  -- What was typed since the save is no obstacle: the server knows where the words are now.
  person.write("a $ repeat (forward left)")
  insert(0, 0, "# typed at once", "", "")
  await_lit("3:13 forward")
  await_lit("3:21 left")

  -- Elsewhere.
  vim.cmd.ImprovSeek("5000.5")
  await_status("^▶ beat 5%d%d%d/∞")
  await_lit("3:21 left")
  await_lit("3:13 forward")

  vim.cmd.ImprovPause()
  await_status("^‖ beat %d+/∞, 120 beats/min, simulator$")
  assert(person.lit() == "3:13 forward" or person.lit() == "3:21 left", person.lit())
  vim.cmd.ImprovResume()
  await_status("^▶ beat")

  assert(vim.deep_equal(vim.fn.getcompletion("ImprovMute ", "cmdline"), { "a" }))
  vim.cmd.ImprovMute("a")
  person.await_message("a muted")
  await_lit("")
  vim.cmd.ImprovMute("a")
  person.await_message("all robots may move")
  await_lit("3:13 forward")

  vim.g.improv_playing = false
  await_lit("")
  vim.g.improv_playing = nil
  await_lit("3:21 left")

  vim.g.page = nil
  vim.cmd.ImprovPage()
  person.await("the page", function() return vim.g.page end)
  vim.cmd.ImprovRestart()
  await_status("^▶ beat %d%d?/∞")

  -- The buffer goes, and the dance goes on; the lights come back with the next save.
  vim.cmd.bwipeout { bang = true }
  vim.cmd.edit("dance.improv")
  await_status("^▶ beat")
  vim.cmd.write()
  await_lit("1:13 forward")

  person.write("a $ forward")
  await_status("^■ ended$")
  assert(person.marks() == 0)

  -- The server's end leaves nothing.
  person.write("a $ repeat forward")
  await_lit("1:12 forward")
  local client = vim.lsp.get_clients({ bufnr = 0 })[1]
  vim.lsp.stop_client(client.id)
  person.await("the end of the server", function() return has_ended(client) and person.marks() == 0 end)
  await_status("^$")
  assert(person.timers() == 0) -- the server keeps the time
end)
