" Colors for Improv programs; editors/generate.py writes the word lists.
if exists('b:current_syntax')
  finish
endif

syntax keyword improvBeat beat
syntax keyword improvPrimitive forward backward left right halfleft halfright rest strafeleft straferight up down
syntax keyword improvTransformer reverse retrograde repeat reflect fast slow scale fit ramp ease accumulate canon choose shuffle chance seed until pause
syntax keyword improvConditional if else not
syntax keyword improvPlane YZ XZ XY sagittal frontal transverse

syntax match improvHead '\v^\s*\K\k*%(\s+\K\k*)*%(\s*\(\s*\K\k*\s*\))*\ze\s*\=' contains=improvParameter,improvName
syntax match improvParameter '\v\K\k*' contained
syntax match improvName '\v%(^\s*)@<=\K\k*' contained
syntax match improvRobot '\v\K\k*\ze%(\s+\K\k*)*\s*\$'
syntax match improvNumber '\v<\d*\.?\d+%(>|%(cm|mm|m|deg)>|°)'
syntax match improvRadius '\v<radius>\ze\s*[.0-9]'
syntax match improvOperator '||\|[=$*/]'
syntax match improvScene '\v^\s*\zs-{3,}' nextgroup=improvTitle skipwhite
syntax match improvTitle '\v\K\k*\ze\s*%(#|$)' contained

" The opening: `ada bo at circle 2`, `ada is puppet`, `room 6 4`. Within brackets, `bar 3` is a phrase and its number.
syntax match improvOpening '\v^\s*\zs%(room|bar)>\ze\s*[-+.0-9][^=$#]*%(#|$)' nextgroup=@improvPlace skipwhite
syntax match improvRobot '\v^\s*\zs%(else>)@!\K\k*%(\s+\K\k*){-}\ze\s+at>%(\s*[-+.0-9]|\s+%(circle|line|grid)>)[^=$#]*%(#|$)' nextgroup=improvOpening skipwhite
syntax match improvRobot '\v^\s*\zs%(else>)@!\K\k*%(\s+\K\k*)*\ze\s+is\s+\K\k*%(-+\k+)*\s*%(#|$)' nextgroup=improvOpening skipwhite
syntax match improvOpening '\v<%(at|facing|around)>' contained nextgroup=@improvPlace skipwhite
syntax match improvOpening '\v<is>' contained nextgroup=improvProfile skipwhite
syntax match improvChoice '\v<%(circle|line|grid|in|out)>' contained nextgroup=@improvPlace skipwhite
syntax match improvProfile '\v\K\k*%(-+\k+)*' contained
syntax match improvNumber '\v[-+]?\d*\.?\d+%(>|%(cm|mm|m|deg)>|°)' contained nextgroup=@improvPlace skipwhite
syntax match improvOperator '[*/]' contained nextgroup=@improvPlace skipwhite
syntax cluster improvPlace contains=improvOpening,improvChoice,improvNumber,improvOperator
syntax region improvBrackets start='[(\[]' end='[)\]]' end='\v\ze\n\s*%(beat\s+[-+.0-9]|---|\K\k*%(\s+\K\k*|\s*\(\s*\K\k*\s*\))*\s*\=|\K[^()\[\]$=|\n]*\$)'
\ transparent contains=TOP,improvOpening,improvRobot,improvHead,improvScene
syntax sync fromstart

syntax match improvComment '#.*' contains=@Spell

highlight default link improvBeat Keyword
highlight default link improvPrimitive Function
highlight default link improvTransformer Statement
highlight default link improvConditional Conditional
highlight default link improvPlane Constant
highlight default link improvName Identifier
highlight default link improvParameter Identifier
highlight default link improvRobot Type
highlight default link improvNumber Number
highlight default link improvRadius Statement
highlight default link improvOperator Operator
highlight default link improvScene Operator
highlight default link improvTitle Title
highlight default link improvOpening Keyword
highlight default link improvChoice Constant
highlight default link improvProfile Constant
highlight default link improvComment Comment

let b:current_syntax = 'improv'
