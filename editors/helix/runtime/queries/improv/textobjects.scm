; A statement is a function, an item in a series is an entry, and a transformer's argument is a parameter.

(definition movement: (_) @function.inside) @function.around
(play movement: (_) @function.inside) @function.around

(series (_) @entry.inside @entry.around)

(transformation [(number) (plane)] @parameter.inside @parameter.around)

(comment) @comment.inside
(comment)+ @comment.around
