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
syntax match improvNumber '\v<\d*\.?\d+>'
syntax match improvOperator '||\|[=$*/]'
syntax match improvScene '\v^\s*\zs-{3,}'
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
highlight default link improvOperator Operator
highlight default link improvScene Operator
highlight default link improvComment Comment

let b:current_syntax = 'improv'
