" The colors are those of the folder for Neovim, which lies beside this one.
execute 'source' fnameescape(expand('<sfile>:p:h:h:h') .. '/neovim/syntax/improv.vim')
