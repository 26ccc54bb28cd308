-- The words of a playing program, as extmarks in its buffer: they move with the text, and some are highlighted.

local M = {}

local SPACE = vim.api.nvim_create_namespace("improv.playing")

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

local function mark(words, index, row, column, end_row, end_column, group)
  return vim.api.nvim_buf_set_extmark(words.buffer, SPACE, row, column, {
    id = words.marks[index],
    end_row = end_row,
    end_col = end_column,
    hl_group = group,
    priority = 200, -- above the colors of the syntax
    strict = false,
    invalidate = true, -- a deleted word is not highlighted
  })
end

--- Mark the words of `improv/evaluated`, or of an answer to `improv/moments`, known from beat `from` on.
function M.place(buffer, encoding, told, from)
  local words = { buffer = buffer, robots = told.robots, from = from, marks = {}, lit = {} }
  for index, range in ipairs(told.ranges) do
    local row, column, end_row, end_column = unpack(range)
    column = byte_column(buffer, row, column, encoding)
    end_column = byte_column(buffer, end_row, end_column, encoding)
    words.marks[index] = mark(words, index, row, column, end_row, end_column)
  end
  return words
end

--- The moment of a robot that plays at a beat, or the next one, or nil.
local function moment_at(moments, beat)
  local low, high = 1, #moments + 1
  while low < high do
    local middle = math.floor((low + high) / 2)
    if moments[middle][2] > beat then
      high = middle
    else
      low = middle + 1
    end
  end
  return moments[low]
end

local function set_lit(words, index, lit)
  local row, column, details =
    unpack(vim.api.nvim_buf_get_extmark_by_id(words.buffer, SPACE, words.marks[index], { details = true }))
  if row and not details.invalid then -- otherwise the word is deleted; undo restores its mark unchanged
    mark(words, index, row, column, details.end_row, details.end_col, lit and "ImprovPlaying" or nil)
    words.lit[index] = lit or nil
  end
end

--- Highlight the words that play at a beat, except those of silent robots. Returns the beat at which that changes.
function M.light(words, beat, is_silent)
  local wanted, change = {}, math.huge
  for robot, stretch in pairs(words.robots) do
    local moment = moment_at(stretch.moments, beat)
    if moment then
      local plays = moment[1] <= beat
      change = math.min(change, plays and moment[2] or moment[1])
      for _, index in ipairs(plays and not is_silent(robot) and moment[3] or {}) do
        wanted[index + 1] = true
      end
    end
  end
  M.darken(words, wanted)
  for index in pairs(wanted) do
    if not words.lit[index] then
      set_lit(words, index, true)
    end
  end
  return change
end

--- Remove the highlights, except from the words in `wanted`.
function M.darken(words, wanted)
  for index in pairs(words.lit) do
    if not (wanted and wanted[index]) then
      set_lit(words, index, false)
    end
  end
end

--- Remove all marks from the buffer.
function M.clear(words)
  if vim.api.nvim_buf_is_valid(words.buffer) then
    for _, id in ipairs(words.marks) do
      vim.api.nvim_buf_del_extmark(words.buffer, SPACE, id)
    end
  end
end

return M
