-- A person's session with an open, wrong program. Each step waits for what the person would see.

local LIMIT = 30000 -- milliseconds, for a busy machine

local function await(what, seen)
  assert(vim.wait(LIMIT, seen, 10), what .. " was not seen; messages:\n" .. vim.fn.execute("messages"))
end

local function message(text)
  return function() return vim.fn.execute("messages"):find(text, 1, true) end
end

local function floating_text()
  for _, window in ipairs(vim.api.nvim_list_wins()) do
    if vim.api.nvim_win_get_config(window).relative ~= "" then
      return table.concat(vim.api.nvim_buf_get_lines(vim.api.nvim_win_get_buf(window), 0, -1, false), "\n")
    end
  end
  return ""
end

local function color(word)
  vim.fn.cursor(1, 1)
  local line, column = unpack(vim.fn.searchpos([[\<]] .. word .. [[\>]], "c"))
  return vim.fn.synIDattr(vim.fn.synID(line, column, 1), "name")
end

local function token(word)
  vim.fn.cursor(1, 1)
  local line, column = unpack(vim.fn.searchpos([[\<]] .. word .. [[\>]], "c"))
  local found = vim.lsp.semantic_tokens.get_at_pos(0, line - 1, column - 1)
  return found and found[1] and found[1].type
end

local function rename(word, new)
  vim.fn.cursor(1, 1)
  vim.fn.search([[\<]] .. word .. [[\>]])
  vim.lsp.buf.rename(new)
  await("the name " .. new, function() return vim.fn.search([[\<]] .. new .. [[\>]], "nw") > 0 end)
end

local function completions(line, column)
  local client = vim.lsp.get_clients({ bufnr = 0 })[1]
  vim.fn.cursor(line, column)
  local params = vim.lsp.util.make_position_params(0, client.offset_encoding)
  local answer = vim.lsp.buf_request_sync(0, "textDocument/completion", params, LIMIT)[client.id]
  return vim.tbl_map(function(item) return item.label end, answer.result.items or answer.result)
end

local function robot(does)
  local command = { vim.env.IMPROV_PYTHON, "-m", "tests.editors.robot", vim.g.page, does }
  local watch = vim.system(command, { cwd = vim.env.IMPROV_ROOT }):wait(2 * LIMIT)
  assert(watch.code == 0, "the robot never " .. does .. ":\n" .. watch.stderr)
end

local function session()
  assert(vim.bo.filetype == "improv")
  assert(vim.bo.commentstring == "# %s")
  assert(color("repeat") == "improvTransformer")
  assert(color("forward") == "improvPrimitive")
  assert(color("turtle1") == "improvRobot")

  await("the error", function() return #vim.diagnostic.get(0) > 0 end)
  local problem = vim.diagnostic.get(0)[1]
  assert(problem.lnum == 2 and problem.message:find("did you mean `left`?", 1, true), vim.inspect(problem))

  vim.fn.cursor(1, 1)
  vim.fn.search("forward")
  vim.lsp.buf.hover()
  await("the timing", function() return floating_text():find("1 beat, 0.50 s at beat 120", 1, true) end)

  await("the robot's color", function() return token("turtle1") == "class" end)
  assert(token("repeat") == "keyword" and not token("lft"))

  rename("turtle1", "anna")
  rename("anna", "turtle1")

  local words = completions(3, 11)
  assert(vim.tbl_contains(words, "forward") and vim.tbl_contains(words, "repeat"), vim.inspect(words))

  vim.cmd.write()
  await("why it does not play", message("✗ line 3: `lft` is not known"))
  vim.cmd.substitute("/lft/left/")
  await("the end of the error", function() return #vim.diagnostic.get(0) == 0 end)
  await("the movement's color", function() return token("left") == "function" end)
  vim.cmd.write()
  await("what plays", message("▶ turtle1 ∞, endless at beat 120, simulator"))
  await("the page", function() return vim.g.page end)
  robot("moves")

  vim.cmd.ImprovHush()
  robot("stands")

  vim.cmd.ImprovPlay()
  robot("moves")
end

local passed, problem = xpcall(session, debug.traceback)
if passed then
  vim.cmd.quitall()
else
  io.stderr:write(problem, "\n")
  vim.cmd.cquit()
end
