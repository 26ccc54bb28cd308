(document) @local.scope

(definition name: (name) @local.definition.variable)
(name) @local.reference
