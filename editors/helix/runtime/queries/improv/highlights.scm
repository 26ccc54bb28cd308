; Colors, in the names of Helix's themes. Neovim has its own: editors/tree-sitter-improv/queries.

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
