; A statement is a function, an item of a series an entry, what a transformer is told a parameter.

(definition movement: (_) @function.inside) @function.around
(play movement: (_) @function.inside) @function.around

(series (_) @entry.inside @entry.around)

(transformation [(number) (plane)] @parameter.inside @parameter.around)

(comment) @comment.inside
(comment)+ @comment.around
