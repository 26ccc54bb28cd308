[(definition) (play) (group) (squeeze)] @indent

[")" "]"] @outdent
