" The language server, for ALE.
call ale#Set('improv_executable', 'improv-ls')
call ale#Set('improv_config', {})

" Files that share an improv.toml share a server and a stage.
function! ale_linters#improv#improv_ls#Root(buffer) abort
    let l:toml = ale#path#FindNearestFile(a:buffer, 'improv.toml')
    return fnamemodify(empty(l:toml) ? bufname(a:buffer) : l:toml, ':p:h')
endfunction

call ale#linter#Define('improv', {
\   'name': 'improv_ls',
\   'lsp': 'stdio',
\   'executable': {buffer -> ale#Var(buffer, 'improv_executable')},
\   'command': '%e',
\   'lsp_config': {buffer -> ale#Var(buffer, 'improv_config')},
\   'project_root': function('ale_linters#improv#improv_ls#Root'),
\})
