; Colors, with the names that Helix's themes use. For Neovim, see editors/tree-sitter-improv/queries.

(comment) @comment.line
(number) @constant.numeric
(beat) @keyword
(transformer) @keyword.control
(primitive) @function.builtin
(plane) @constant.builtin
(name) @variable
(robot) @type

["=" "$" "||"] @operator
["(" ")" "[" "]"] @punctuation.bracket
