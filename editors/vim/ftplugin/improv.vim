if exists('b:did_ftplugin')
  finish
endif
let b:did_ftplugin = 1
let b:undo_ftplugin = 'setlocal commentstring< comments< omnifunc<'
\ .. ' | delcommand -buffer ImprovPlay | delcommand -buffer ImprovStop | delcommand -buffer ImprovHush | delcommand -buffer ImprovCue | delcommand -buffer ImprovPage'

setlocal commentstring=#\ %s comments=:#

if exists('g:loaded_ale')
  setlocal omnifunc=ale#completion#OmniFunc
  call ale#linter#GetAll(['improv']) " has ALE read our linter, which sets the variable's default
  if !executable(ale#Var(bufnr(''), 'improv_executable'))
    echohl WarningMsg
    echomsg 'improv-ls not found: install Improv and put it on your PATH, or set g:ale_improv_executable'
    echohl None
  endif
endif

function! s:Send(params, linter, server) abort
  " First what was typed: otherwise a line number might mean another line.
  call ale#lsp#NotifyForChanges(a:server.connection_id, a:server.buffer)
  call ale#lsp#Send(a:server.connection_id, [0, 'workspace/executeCommand', a:params])
endfunction

function! s:Execute(command, arguments) abort
  let l:params = {'command': a:command, 'arguments': a:arguments}
  let l:linter = filter(ale#linter#GetAll(['improv']), {_, each -> each.name is# 'improv_ls'})[0]
  call ale#lsp_linter#StartLSP(bufnr(''), l:linter, function('s:Send', [l:params]))
endfunction

" Play the program, or these lines or a name in it, perhaps alone; `ranges` counts the line numbers of a range.
function! s:Play(alone, ranges, first, last, name) abort
  let l:some = a:ranges ? [a:first, a:last] : empty(a:name) ? [] : [a:name]
  let l:command = a:alone && !empty(l:some) ? 'improv.only' : 'improv.play'
  call s:Execute(l:command, [ale#util#ToURI(expand('%:p'))] + l:some)
endfunction

command! -buffer -bar -bang -range -nargs=? ImprovPlay call s:Play(<bang>0, <range>, <line1>, <line2>, <q-args>)
command! -buffer -bar ImprovStop call s:Execute('improv.stop', [])
" Its earlier name.
command! -buffer -bar ImprovHush ImprovStop
command! -buffer -bar ImprovCue call s:Execute('improv.cue', [])
command! -buffer -bar ImprovPage call s:Execute('improv.page', [])
