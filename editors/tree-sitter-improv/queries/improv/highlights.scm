; Colors, with the names that Neovim and the tree-sitter CLI use. For Helix, see editors/helix/runtime.

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
