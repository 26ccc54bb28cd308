" The colors come from the Neovim folder beside this one.
execute 'source' fnameescape(expand('<sfile>:p:h:h:h') .. '/neovim/syntax/improv.vim')
