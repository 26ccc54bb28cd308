(document) @local.scope

; A definition is the scope of its parameters, but not of its name.
(definition) @local.scope

((definition
  name: (name) @local.definition.var)
  (#set! definition.var.scope "parent"))

(definition parameter: (parameter) @local.definition.parameter)

[(name) (parameter)] @local.reference
