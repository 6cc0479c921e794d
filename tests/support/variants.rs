//! Every builder as it is registered.

use bvh_lab::build::{BUILDERS, BuildOptions, Builder, Parameter, Preset};

/// Every reading, engine and arity of every builder, with and without rule Q8, and with so few candidates that a literal search
/// over mixed planes ends soon.
pub fn variants() -> impl Iterator<Item = (&'static Builder, BuildOptions)> {
    BUILDERS.iter().flat_map(|builder| {
        builder.variants(BuildOptions::default()).into_iter().flat_map(move |options| {
            let takes = |parameter| builder.parameters.contains(&parameter);
            let few = if options.preset == Preset::Text { 5 } else { 9 };
            let candidates = takes(Parameter::Candidates).then_some(few);
            let q8 = if takes(Parameter::Q8) { &[true, false][..] } else { &[true] };
            q8.iter().map(move |&q8| (builder, BuildOptions { candidates, q8, ..options }))
        })
    })
}
