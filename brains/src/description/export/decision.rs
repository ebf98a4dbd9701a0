//! The six methods of decision.

use super::fragment::Fragment;
use super::writer::{Writer, c};
use crate::composed::{Decision, Motor};
use crate::decision::{Condition, Cooperative, Hydraulic, Layers, Machine, Node, Tree, Utility, Weight};

/// The functions `brain_choose`, which applies the method, and `brain_decide`, which lets a fixed action run to its end first.
pub(super) fn write(writer: &mut Writer, decision: &Decision, motors: &[Motor], fixed: &[usize]) {
    match decision {
        Decision::Utility { change_cost } => utility(writer, *change_cost, motors.len()),
        Decision::Machine(machine) => self::machine(writer, machine),
        Decision::Layers(layers) => self::layers(writer, layers),
        Decision::Tree(tree) => self::tree(writer, tree),
        Decision::Hydraulic(hydraulic) => self::hydraulic(writer, hydraulic),
        Decision::Cooperative(cooperative) => self::cooperative(writer, cooperative),
    }
    let signature = "uint16_t brain_decide(struct brain *brain, brain_real seconds)";
    writer.function("The motor behaviour that is to be active, by its place.", signature, |writer| {
        if matches!(decision, Decision::Utility { .. } | Decision::Cooperative(_)) {
            motors.iter().enumerate().for_each(|(place, motor)| follow(writer, place, &motor.utility));
        }
        for place in fixed {
            let head = format!("if (brain->driving[{place}] && brain->runs_{place})");
            writer.block(head, |writer| stay(writer, decision, *place, motors.len()));
        }
        writer.line("return brain_choose(brain, seconds);");
    });
}

/// A fixed action goes on.
fn stay(writer: &mut Writer, decision: &Decision, place: usize, motors: usize) {
    match decision {
        Decision::Hydraulic(_) => writer.line("brain_choose(brain, seconds);"),
        Decision::Cooperative(_) => {
            for motor in 0..motors {
                writer.line(format_args!("brain->shares[{motor}] = {};", u8::from(motor == place)));
            }
        }
        Decision::Utility { .. } | Decision::Machine(_) | Decision::Layers(_) | Decision::Tree(_) => {}
    }
    writer.line(format_args!("return {place};"));
}

/// A utility follows its target, Eq. (8.4).
fn follow(writer: &mut Writer, place: usize, utility: &Utility) {
    writer.uses(Fragment::Utility);
    let function = utility.function();
    writer.start(format_args!("utilities[{place}]"), c(utility.value()));
    let terms = function.weights.iter().enumerate();
    let terms: Vec<_> = terms.map(|(z, weight)| format!("{} * brain->z[{z}]", c(*weight))).collect();
    let sum = if terms.is_empty() { "-0.0".to_owned() } else { terms.join(" + ") };
    let target = format!("brain_tanh({} * ({sum} + {}))", c(function.slope), c(function.bias));
    let longest_s = function.tau_s.min(function.gamma_tau_s) / 4.0;
    let (tau_s, longest_s) = (c(function.tau_s), c(longest_s));
    writer.line(format_args!(
        "brain_follow(&brain->utilities[{place}], {target}, seconds, {tau_s}, {longest_s});"
    ));
}

/// The function that chooses, of which `seconds` need not be used.
fn choose(writer: &mut Writer, meaning: &str, body: impl FnOnce(&mut Writer)) {
    let signature = "uint16_t brain_choose(struct brain *brain, brain_real seconds)";
    writer.function(meaning, signature, |writer| {
        writer.line("(void)seconds;");
        body(writer);
    });
}

fn utility(writer: &mut Writer, change_cost: f64, motors: usize) {
    writer.uses(Fragment::Greatest);
    writer.field(format_args!("brain_real utilities[{motors}]"), "of the motor behaviours");
    choose(writer, "The greatest utility decides.", |writer| {
        writer.line(format_args!("uint16_t best = brain_greatest(brain->utilities, {motors});"));
        if change_cost > 0.0 {
            let value = |place: &str| format!("brain->utilities[{place}]");
            let (best, active, cost) = (value("best"), value("brain->active"), c(change_cost));
            writer.line(format_args!(
                "if (brain->active < {motors} && {best} <= {active} + {cost}) return brain->active;"
            ));
        }
        writer.line("return best;");
    });
}

fn machine(writer: &mut Writer, machine: &Machine) {
    state(writer, machine.active);
    choose(writer, "A finite-state machine decides.", |writer| {
        for (place, transition) in machine.transitions.iter().enumerate() {
            let from = transition.from.map(|from| format!("brain->state == {from}"));
            let other = format!("brain->state != {}", transition.to);
            let when = from.into_iter().chain([other]).chain(transition.when.iter().map(condition));
            let when = when.collect::<Vec<_>>().join(" && ");
            let head = if place == 0 { "if" } else { "else if" };
            writer.line(format_args!("{head} ({when}) brain->state = {};", transition.to));
        }
        writer.line("return brain->state;");
    });
}

fn layers(writer: &mut Writer, layers: &Layers) {
    choose(writer, "The highest layer decides that wants to.", |writer| {
        writer.line("(void)brain;");
        for (when, behavior) in &layers.layers {
            writer.line(format_args!("if ({}) return {behavior};", all(when)));
        }
        writer.line(format_args!("return {};", layers.base));
    });
}

fn tree(writer: &mut Writer, tree: &Tree) {
    state(writer, tree.active);
    writer.line("");
    writer.line("enum { BRAIN_FAILS, BRAIN_SUCCEEDS, BRAIN_RUNS };");
    let mut nodes = 0;
    let root = node(writer, &tree.root, &mut nodes);
    choose(writer, "A behaviour tree decides.", |writer| {
        writer.line(format_args!("(void){root};"));
        writer.line("return brain->state;");
    });
}

/// The function of a node, behind those of its parts; a call of it.
fn node(writer: &mut Writer, node: &Node, nodes: &mut usize) -> String {
    let parts: Vec<_> = match node {
        Node::Select(parts) | Node::Sequence(parts) => {
            parts.iter().map(|part| self::node(writer, part, nodes)).collect()
        }
        Node::Invert(part) => vec![self::node(writer, part, nodes)],
        Node::Condition(_) | Node::Behavior(_) => Vec::new(),
    };
    let name = format!("brain_node_{nodes}");
    *nodes += 1;
    let signature = format!("uint8_t {name}(struct brain *brain)");
    writer.function("A node of the tree.", signature, |writer| match node {
        Node::Select(_) => first(writer, &parts, "BRAIN_FAILS"),
        Node::Sequence(_) => first(writer, &parts, "BRAIN_SUCCEEDS"),
        Node::Invert(_) => {
            parts.iter().for_each(|part| writer.line(format_args!("uint8_t status = {part};")));
            writer.line(
                "return status == BRAIN_RUNS ? BRAIN_RUNS : status == BRAIN_FAILS ? BRAIN_SUCCEEDS : BRAIN_FAILS;",
            );
        }
        Node::Condition(condition) => {
            let condition = self::condition(condition);
            writer.line(format_args!("return {condition} ? BRAIN_SUCCEEDS : BRAIN_FAILS;"));
        }
        Node::Behavior(behavior) => {
            writer.line(format_args!("brain->state = {behavior};"));
            writer.line("return BRAIN_RUNS;");
        }
    });
    format!("{name}(brain)")
}

/// Parts from the left, until one has another status than this.
fn first(writer: &mut Writer, parts: &[String], on: &str) {
    writer.line(format_args!("uint8_t status = {on};"));
    writer.line("(void)brain;");
    for part in parts {
        writer.line(format_args!("if (status == {on}) status = {part};"));
    }
    writer.line("return status;");
}

fn hydraulic(writer: &mut Writer, hydraulic: &Hydraulic) {
    writer.uses(Fragment::Reservoir);
    state(writer, hydraulic.base);
    let count = hydraulic.reservoirs.len();
    writer.field(format_args!("brain_real energies[{}]", count.max(1)), "of the reservoirs");
    choose(writer, "The greatest flow of energy decides.", |writer| {
        writer.line(format_args!("brain_real flows_hz[{}] = {{0}};", count.max(1)));
        writer.line("uint16_t strongest;");
        writer.line("if (!(seconds > 0)) return brain->state;");
        for (place, reservoir) in hydraulic.reservoirs.iter().enumerate() {
            writer.start(format_args!("energies[{place}]"), c(reservoir.energy));
            let releaser = reservoir.releaser.map_or_else(|| "0".to_owned(), |z| format!("brain->z[{z}]"));
            let numbers =
                [reservoir.fill_hz, reservoir.capacity, reservoir.outflow_hz, reservoir.spring].map(c);
            let numbers = numbers.map(|number| number.to_string()).join(", ");
            writer.line(format_args!(
                "flows_hz[{place}] = brain_flow(&brain->energies[{place}], {releaser}, seconds, {numbers});"
            ));
        }
        writer.line(format_args!("strongest = brain_greatest(flows_hz, {});", count.max(1)));
        writer.line(format_args!("brain->state = {};", hydraulic.base));
        for (place, reservoir) in hydraulic.reservoirs.iter().enumerate() {
            let (is_strongest, behavior) = (format!("strongest == {place}"), reservoir.behavior);
            writer.line(format_args!(
                "if ({is_strongest} && flows_hz[{place}] > 0) brain->state = {behavior};"
            ));
        }
        writer.line("return brain->state;");
    });
}

fn cooperative(writer: &mut Writer, cooperative: &Cooperative) {
    writer.uses(Fragment::Greatest);
    let count = cooperative.weights.len();
    writer.field(format_args!("brain_real utilities[{count}]"), "of the motor behaviours");
    writer.field(format_args!("brain_real shares[{count}]"), "of the motor behaviours in the command");
    writer.field(format_args!("brain_real suggestions[{count}][2]"), "of the motor behaviours");
    choose(writer, "The motor behaviours drive together.", |writer| {
        writer.line("brain_real sum = -0.0;");
        writer.line("uint16_t i;");
        for (place, weight) in cooperative.weights.iter().enumerate() {
            let weight = match weight {
                Weight::Constant(weight) => c(*weight).to_string(),
                Weight::Utility(times) => {
                    writer.uses(Fragment::Max);
                    format!("{} * brain_max(brain->utilities[{place}], 0)", c(*times))
                }
            };
            writer.line(format_args!("brain->shares[{place}] = {weight};"));
        }
        writer.line(format_args!("for (i = 0; i < {count}; i++) sum += brain->shares[i];"));
        writer.line(format_args!("for (i = 0; sum > 0 && i < {count}; i++) brain->shares[i] /= sum;"));
        writer.line(format_args!("return brain_greatest(brain->shares, {count});"));
    });
}

/// The behaviour that the method remembers.
fn state(writer: &mut Writer, start: usize) {
    writer.field("uint16_t state", "the motor behaviour that was chosen last");
    writer.start("state", start);
}

fn all(conditions: &[Condition]) -> String {
    let texts: Vec<_> = conditions.iter().map(condition).collect();
    if texts.is_empty() { "1".to_owned() } else { texts.join(" && ") }
}

fn condition(condition: &Condition) -> String {
    let (variable, comparison, number) = condition.parts();
    format!("brain->z[{variable}] {comparison} {}", c(number))
}
