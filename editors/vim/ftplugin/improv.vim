if exists('b:did_ftplugin')
  finish
endif
let b:did_ftplugin = 1
let b:undo_ftplugin = 'setlocal commentstring< comments< omnifunc<'
\ .. ' | delcommand -buffer ImprovPlay | delcommand -buffer ImprovHush | delcommand -buffer ImprovPage'

setlocal commentstring=#\ %s comments=:#

if exists('g:loaded_ale')
  setlocal omnifunc=ale#completion#OmniFunc
  if !executable(ale#Var(bufnr(''), 'improv_executable'))
    echohl WarningMsg
    echomsg 'improv-ls not found: install Improv and put it on your PATH, or set g:ale_improv_executable'
    echohl None
  endif
endif

function! s:Execute(command, arguments) abort
  let l:params = {'command': a:command, 'arguments': a:arguments}
  call ale#lsp_linter#SendRequest(bufnr(''), 'improv_ls', [0, 'workspace/executeCommand', l:params])
endfunction

command! -buffer -bar ImprovPlay call s:Execute('improv.play', [ale#util#ToURI(expand('%:p'))])
command! -buffer -bar ImprovHush call s:Execute('improv.hush', [])
command! -buffer -bar ImprovCue call s:Execute('improv.cue', [])
command! -buffer -bar ImprovPage call s:Execute('improv.page', [])
