[(definition) (play) (group) (squeeze)] @indent.begin

[")" "]"] @indent.branch @indent.end
