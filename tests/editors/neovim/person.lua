-- What a person at Neovim sees and waits for.

local M = {}

M.LIMIT = 60000 -- milliseconds, for a busy machine

--- What tells, when something is never seen, why: the messages, each server with what it has not answered, and the log.
local function circumstances()
  local servers = vim.tbl_map(function(client)
    local buffers = vim.tbl_keys(client.attached_buffers)
    return { id = client.id, initialized = client.initialized, unanswered = client.requests, buffers = buffers }
  end, vim.lsp.get_clients())
  local path = vim.lsp.log.get_filename()
  local log = vim.fn.filereadable(path) == 1 and vim.fn.readfile(path, "", -20) or {}
  local parts = { "messages:" .. vim.fn.execute("messages"), "servers: " .. vim.inspect(servers), "log:" }
  return table.concat(vim.list_extend(parts, log), "\n")
end

--- Wait until something is seen.
function M.await(what, seen)
  if not vim.wait(M.LIMIT, seen, 25) then
    error(what .. " was not seen; " .. circumstances())
  end
end

function M.await_message(text)
  M.await(text, function() return vim.fn.execute("messages"):find(text, 1, true) end)
end

function M.await_status(pattern)
  M.await("the status line " .. pattern, function() return require("improv").statusline():find(pattern) end)
end

--- The words that are lit, by their place: `3:19 forward`.
function M.lit()
  local found = {}
  local space = vim.api.nvim_create_namespace("improv.playing")
  for _, mark in ipairs(vim.api.nvim_buf_get_extmarks(0, space, 0, -1, { details = true })) do
    local _, row, column, more = unpack(mark)
    if more.hl_group == "ImprovPlaying" and not more.invalid then
      local text = vim.api.nvim_buf_get_text(0, row, column, more.end_row, more.end_col, {})[1]
      found[#found + 1] = ("%d:%d %s"):format(row + 1, column + 1, text)
    end
  end
  return table.concat(found, ", ")
end

function M.await_lit(words)
  M.await(words .. " in light", function() return M.lit() == words end)
end

--- How many marks of ours are in the buffer.
function M.marks()
  local space = vim.api.nvim_create_namespace("improv.playing")
  return #vim.api.nvim_buf_get_extmarks(0, space, 0, -1, {})
end

local new_timer, timers = vim.uv.new_timer, {}
vim.uv.new_timer = function()
  local timer = new_timer()
  if debug.getinfo(2, "S").source:find("improv", 1, true) then
    table.insert(timers, timer)
  end
  return timer
end

--- How many timers of ours are not closed.
function M.timers()
  return #vim.tbl_filter(function(timer) return not timer:is_closing() end, timers)
end

--- Wait until a robot `moves`, or all of them `stands`.
function M.robot(does)
  local command = { vim.env.IMPROV_PYTHON, "-m", "tests.editors.robot", vim.g.page, does }
  local watch = vim.system(command, { cwd = vim.env.IMPROV_ROOT }):wait(2 * M.LIMIT)
  assert(watch.code == 0, "the robot never " .. does .. ":\n" .. watch.stderr)
end

--- Undo goes back to here, as if keys had been typed since.
function M.break_undo()
  vim.o.undolevels = vim.o.undolevels
end

function M.write(...)
  vim.api.nvim_buf_set_lines(0, 0, -1, false, { ... })
  vim.cmd.write()
end

--- Open the program anew, as it was.
function M.open(...)
  vim.cmd.edit { vim.env.IMPROV_PROGRAM, bang = true }
  vim.api.nvim_buf_set_lines(0, 0, -1, false, { ... })
  M.await("the server", function() return #vim.lsp.get_clients { bufnr = 0 } > 0 end)
end

--- Go through a part of a session. If it fails, Neovim ends, and says why where the test reads it.
function M.session(act)
  local passed, problem = xpcall(act, debug.traceback)
  local said = vim.fn.execute("messages")
  if passed and said:find("stack traceback", 1, true) then
    passed, problem = false, said
  end
  if not passed then
    io.stderr:write(problem, "\n")
    vim.cmd.cquit()
  end
  vim.cmd.messages("clear")
end

return M
