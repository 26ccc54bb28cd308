; Colors, in the names of Neovim and of tree-sitter's command line. Helix has its own: editors/helix/runtime.

(comment) @comment @spell
(number) @number
(beat) @attribute
(transformer) @keyword
(primitive) @function.builtin
(plane) @constant
(name) @variable
(robot) @type

["=" "$" "||"] @operator
["(" ")" "[" "]"] @punctuation.bracket
