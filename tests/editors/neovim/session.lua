-- A person's session with an open, wrong program. Each step waits for what the person would see.

local person = require("person")
local await = person.await

person.session(function()
  assert(vim.bo.filetype == "improv")
  assert(vim.bo.commentstring == "# %s")

  await("the error", function() return #vim.diagnostic.get(0) > 0 end)
  local problem = vim.diagnostic.get(0)[1]
  assert(problem.lnum == 2 and problem.message:find("did you mean `left`?", 1, true), vim.inspect(problem))

  vim.cmd.write()
  person.await_message("✗ line 3: `lft` is not defined")
  assert(person.marks() == 0)
  vim.cmd("3substitute/lft/left/")
  await("the end of the error", function() return #vim.diagnostic.get(0) == 0 end)
  vim.cmd.write()
  person.await_status("^▶ beat %d+/∞, 120 beats/min, simulator$")
  person.await_lit("3:19 forward")
  person.await_lit("3:27 left")
  person.await_lit("3:19 forward")
  await("the page", function() return vim.g.page end)
  person.robot("moves")

  -- A wrong save: the dance goes on.
  person.break_undo()
  vim.cmd.substitute("/left/lft/")
  vim.cmd.messages("clear")
  vim.cmd.write()
  person.await_message("✗ line 3: `lft` is not defined")
  person.robot("moves")
  person.await_lit("3:19 forward")
  vim.cmd.undo()

  vim.cmd.ImprovStop()
  person.await_status("^■ stopped$")
  assert(person.marks() == 0, person.lit())
  person.robot("stands")

  vim.cmd.ImprovPlay()
  person.robot("moves")
  person.await_lit("3:27 left")

  -- The version before, and what played.
  vim.cmd("3substitute/left/right rest/")
  vim.cmd.write()
  person.await_lit("3:27 right")
  vim.cmd.messages("clear")
  vim.cmd.ImprovBefore()
  person.await_message("▶ turtle1 ∞")
  vim.ui.select = function(items, options, take)
    assert(#items == 3 and options.format_item(items[1]):find("dance.improv  turtle1 $ repeat (forward left)", 1, true))
    take(items[2])
  end
  vim.cmd.ImprovHistory()
  await("a program of the history", function() return vim.bo.buftype == "nofile" end)
  assert(vim.fn.getline(3) == "turtle1 $ repeat (forward right rest)", vim.fn.getline(3))
  vim.cmd.ImprovStop()

  -- The server finds this out after it has answered, and nobody types meanwhile.
  person.open("ada at 0 0", "bo at 1 -1 facing 90", "ada $ forward", "bo $ forward")
  await("a meeting", function() return (vim.diagnostic.get(0)[1] or {}).code == "meets" end)
end)
