; Colors, with the names that Neovim and the tree-sitter CLI use. For Helix, see editors/helix/runtime.

(comment) @comment @spell
(number) @number
(beat) @attribute
["at" "is" "room" "bar" "facing" "around"] @attribute
(transformer) @keyword
["if" "else"] @keyword.conditional
"not" @keyword.operator
"radius" @keyword
(primitive) @function.builtin
[(plane) (formation) (direction) (profile)] @constant
(name) @variable
(parameter) @variable.parameter
(sense) @variable.member
(robot) @type

["=" "$" "||" "*" "/"] @operator
"---" @operator
(title) @label
["(" ")" "[" "]"] @punctuation.bracket
