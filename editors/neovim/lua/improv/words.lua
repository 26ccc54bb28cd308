-- The words that are lit, as extmarks in the buffer of a program: they move with the text.

local M = { FLASH = 200 } -- milliseconds

local SPACE = vim.api.nvim_create_namespace("improv.playing")
local FLASHED = vim.api.nvim_create_namespace("improv.evaluated")

--- The byte offset of a column that the server counts in units of `encoding`.
local function byte_column(buffer, row, column, encoding)
  local line = vim.api.nvim_buf_get_lines(buffer, row, row + 1, false)[1] or ""
  if encoding == "utf-8" then
    return math.min(column, #line)
  elseif vim.fn.has("nvim-0.11") == 1 then
    return vim.str_byteindex(line, encoding, column, false)
  end
  local inside, byte = pcall(vim.str_byteindex, line, column, encoding == "utf-16")
  return inside and byte or #line
end

--- Highlight a range of a buffer.
local function mark(buffer, space, encoding, range, group)
  local row, column, end_row, end_column = unpack(range)
  vim.api.nvim_buf_set_extmark(buffer, space, row, byte_column(buffer, row, column, encoding), {
    end_row = end_row,
    end_col = byte_column(buffer, end_row, end_column, encoding),
    hl_group = group,
    priority = 200, -- above the colors of the syntax
    strict = false,
    invalidate = true, -- a deleted word is not highlighted
  })
end

--- Highlight the words in these ranges of a buffer, and no others.
function M.light(buffer, encoding, ranges)
  M.darken(buffer)
  for _, range in ipairs(ranges) do
    mark(buffer, SPACE, encoding, range, "ImprovPlaying")
  end
end

--- Highlight a range of a buffer for a moment.
function M.flash(buffer, encoding, range)
  mark(buffer, FLASHED, encoding, range, "ImprovEvaluated")
  vim.defer_fn(function()
    if vim.api.nvim_buf_is_valid(buffer) then
      vim.api.nvim_buf_clear_namespace(buffer, FLASHED, 0, -1)
    end
  end, M.FLASH)
end

--- Remove all highlights from a buffer.
function M.darken(buffer)
  if vim.api.nvim_buf_is_valid(buffer) then
    vim.api.nvim_buf_clear_namespace(buffer, SPACE, 0, -1)
  end
end

return M
