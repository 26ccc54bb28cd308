(document) @local.scope

(definition name: (name) @local.definition.var)
(name) @local.reference
