; A statement is a function, an item in a series is an entry, and arguments and parameters are parameters.

(definition movement: (_) @function.inside) @function.around
(play movement: (_) @function.inside) @function.around

(series (_) @entry.inside @entry.around)

(transformation [(number) (plane)] @parameter.inside @parameter.around)
(condition) @parameter.inside @parameter.around
(call (number) @parameter.inside @parameter.around)
(definition parameter: (_) @parameter.inside @parameter.around)

(comment) @comment.inside
(comment)+ @comment.around
