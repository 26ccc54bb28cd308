; A statement is a function, and an item in a series is a parameter.

(definition movement: (_) @function.inner) @function.outer
(play movement: (_) @function.inner) @function.outer

(definition name: (name) @assignment.lhs movement: (_) @assignment.rhs @assignment.inner) @assignment.outer

(series (_) @parameter.inner @parameter.outer)
(call (number) @parameter.inner @parameter.outer)
(definition parameter: (_) @parameter.inner @parameter.outer)

(call) @call.outer

(conditional (_) @conditional.inner) @conditional.outer

(group (_) @block.inner) @block.outer
(squeeze (_) @block.inner) @block.outer

(number) @number.inner
(comment)+ @comment.outer
