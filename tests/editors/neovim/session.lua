-- A person's session with an open, wrong program. Each step waits for what the person would see.

local person = require("person")
local await = person.await

local function floating_text()
  for _, window in ipairs(vim.api.nvim_list_wins()) do
    if vim.api.nvim_win_get_config(window).relative ~= "" then
      return table.concat(vim.api.nvim_buf_get_lines(vim.api.nvim_win_get_buf(window), 0, -1, false), "\n")
    end
  end
  return ""
end

local function place(word)
  vim.fn.cursor(1, 1)
  return unpack(vim.fn.searchpos([[\<]] .. word .. [[\>]], "c"))
end

local function color(word)
  local line, column = place(word)
  return vim.fn.synIDattr(vim.fn.synID(line, column, 1), "name")
end

local function token(word)
  local line, column = place(word)
  local found = vim.lsp.semantic_tokens.get_at_pos(0, line - 1, column - 1)
  return found and found[1] and found[1].type
end

local function rename(word, new)
  place(word)
  vim.lsp.buf.rename(new)
  await("the name " .. new, function() return vim.fn.search([[\<]] .. new .. [[\>]], "nw") > 0 end)
end

local function completions(line, column)
  local client = vim.lsp.get_clients({ bufnr = 0 })[1]
  vim.fn.cursor(line, column)
  local params = vim.lsp.util.make_position_params(0, client.offset_encoding)
  local answer = vim.lsp.buf_request_sync(0, "textDocument/completion", params, person.LIMIT)[client.id]
  return vim.tbl_map(function(item) return item.label end, answer.result.items or answer.result)
end

person.session(function()
  assert(vim.bo.filetype == "improv")
  assert(vim.bo.commentstring == "# %s")
  assert(color("repeat") == "improvTransformer")
  assert(color("forward") == "improvPrimitive")
  assert(color("turtle1") == "improvRobot")

  await("the error", function() return #vim.diagnostic.get(0) > 0 end)
  local problem = vim.diagnostic.get(0)[1]
  assert(problem.lnum == 2 and problem.message:find("did you mean `left`?", 1, true), vim.inspect(problem))

  place("forward")
  vim.lsp.buf.hover()
  await("the timing", function() return floating_text():find("1 beat, 0.50 s at beat 120", 1, true) end)

  await("the robot's color", function() return token("turtle1") == "class" end)
  await("no color of what is not defined", function() return token("repeat") == "keyword" and not token("lft") end)

  rename("turtle1", "anna")
  rename("anna", "turtle1")

  local words = completions(3, 11)
  assert(vim.tbl_contains(words, "forward") and vim.tbl_contains(words, "repeat"), vim.inspect(words))

  vim.cmd.write()
  person.await_message("✗ line 3: `lft` is not defined")
  assert(person.marks() == 0)
  vim.cmd.substitute("/lft/left/")
  await("the end of the error", function() return #vim.diagnostic.get(0) == 0 end)
  await("the movement's color", function() return token("left") == "function" end)
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

  vim.cmd.ImprovHush()
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
  vim.cmd.ImprovHush()
end)
