; Colors, with the names that Helix's themes use. For Neovim, see editors/tree-sitter-improv/queries.

(comment) @comment.line
(number) @constant.numeric
(beat) @keyword
(transformer) @keyword.control
["if" "else"] @keyword.control.conditional
"not" @keyword.operator
(primitive) @function.builtin
(plane) @constant.builtin
(name) @variable
(parameter) @variable.parameter
(sense) @variable.other.member
(robot) @type
(scene) @punctuation.special

["=" "$" "||" "*" "/"] @operator
["(" ")" "[" "]"] @punctuation.bracket
