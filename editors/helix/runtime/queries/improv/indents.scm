[(group) (squeeze)] @indent

[")" "]"] @outdent
