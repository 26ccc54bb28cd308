; Colors, with the names that Neovim and the tree-sitter CLI use. For Helix, see editors/helix/runtime.

(comment) @comment @spell
(number) @number
(beat) @attribute
(transformer) @keyword
["if" "else"] @keyword.conditional
"not" @keyword.operator
(primitive) @function.builtin
(plane) @constant
(name) @variable
(parameter) @variable.parameter
(sense) @variable.member
(robot) @type

["=" "$" "||" "*" "/"] @operator
(scene) @operator
["(" ")" "[" "]"] @punctuation.bracket
