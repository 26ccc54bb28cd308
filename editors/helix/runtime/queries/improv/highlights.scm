; Colors, with the names that Helix's themes use. For Neovim, see editors/tree-sitter-improv/queries.

(comment) @comment.line
(number) @constant.numeric
(beat) @keyword
["at" "is" "room" "bar" "facing" "around"] @keyword
(transformer) @keyword.control
["if" "else"] @keyword.control.conditional
"not" @keyword.operator
"radius" @keyword.control
(primitive) @function.builtin
[(plane) (formation) (direction) (profile)] @constant.builtin
(name) @variable
(parameter) @variable.parameter
(sense) @variable.other.member
(robot) @type
"---" @punctuation.special
(title) @label

["=" "$" "||" "*" "/"] @operator
["(" ")" "[" "]"] @punctuation.bracket
