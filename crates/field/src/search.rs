//! Local search over the singularities of a cross field: moves along edges, cancellation of opposite pairs.
//!
//! In: a factorised [`SmoothnessSystem`] and period jumps. Out: period jumps and angles of a lower objective
//! E + Σ w(v)·|4·I(v)|, E of Eq. (8.1). Holds: every accepted change lowers the objective, or removes a pair that is
//! closer than the cancel distance at a bounded rise; prescribed indices and index sums are kept; angles stay exact
//! minimisers. Not: that no singularity is left beside a curve, where there is no other place.
//! Source: [Bommes2012] §8.2, local search singularity optimization: moving a singularity along an edge changes the
//! edge's period jump, hence the right-hand side only. The exact change of E below is its consequence.
//!
//! With x the angles' response to changing the jumps by δ, and t the turns θ_j - θ_i - κ - π/2·p:
//!
//! ```text
//!   ΔE = -π Σ δ_e t_e + Q,   Q = π/2 Σ δ_e (π/2 δ_e - (x_j - x_i)),
//! ```
//!
//! so Q depends on the path alone, and only the first term on the state.

mod patch;
mod prescriptions;

pub(crate) use prescriptions::index_groups;

use crate::cross_field::CrossField;
use crate::error::FieldError;
use crate::loops::{curve_loops, homology_loops};
use crate::solve::FieldOptions;
use crate::system::SmoothnessSystem;
use crate::transport::Transport;
use patch::Patch;
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, FaceMap, Progress, TriConnectivity, VertexId, VertexMap};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::f64::consts::{FRAC_PI_2, PI};

/// Radians² by which a move must lower the objective, well above rounding errors.
const LEAST_GAIN: f64 = 1e-9;

/// A turn below this needs no exact cost: Q is above 0.15·(π/2)² on every edge of a reasonable mesh.
const SMALLEST_MOVING_TURN: f64 = 0.15 * PI / 4.0;

/// Radians² by which the estimate of a pair's cost may be too large before the pair is overlooked.
const ESTIMATE_MARGIN: f64 = 0.1;

/// Radians² that a twist around a handle or tube must gain at first order for its cost to be computed.
const LEAST_TWIST: f64 = 1e-3;

/// What a search did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SearchCounts {
    /// Moves along one edge.
    pub moves: usize,
    /// Pairs of opposite sign that were joined along a path.
    pub cancelled_pairs: usize,
    /// Quarter turns around handles and tubes.
    pub twists: usize,
    /// Solves of the whole system.
    pub solves: usize,
}

/// Vertices looked at for a place away from curves; in a gap so narrow that none is found, the singularity stays.
const WAY_OUT_VERTICES: usize = 60;

/// Vertices beside the given ones, without them: on curves singularities have room, next to them they have not.
fn beside(mesh: &TriConnectivity, on_curve: &VertexMap<bool>) -> VertexMap<bool> {
    VertexMap::from_fn(mesh.vertex_count(), |v| !on_curve[v] && mesh.neighbours(v).any(|w| on_curve[w]))
}

/// Period jumps with their optimal angles.
pub(crate) struct Search<'a> {
    mesh: &'a TriConnectivity,
    transport: &'a Transport,
    length: &'a EdgeMap<f64>,
    system: &'a SmoothnessSystem<'a>,
    options: &'a FieldOptions,
    /// Edges whose jump stays.
    kept: EdgeMap<bool>,
    /// Vertices of curves that singularities should be clear of.
    on_curve: VertexMap<bool>,
    /// Vertices beside those.
    crowded: VertexMap<bool>,
    /// Vertices of equal group may exchange index: 0 is free, others have prescribed sums.
    group: VertexMap<u32>,
    /// Price of a quarter of index at each vertex; 0 on the boundary, where indices are not counted.
    price: VertexMap<f64>,
    field: CrossField,
    turn: EdgeMap<f64>,
    index: VertexMap<i32>,
    /// Q of a unit change of each edge's jump, once computed.
    unit_cost: EdgeMap<Option<f64>>,
    /// Q of the shortest path between two vertices, once computed.
    pair_cost: BTreeMap<(VertexId, VertexId), f64>,
    /// Q of a loop, once computed.
    loop_cost: BTreeMap<usize, f64>,
    pub counts: SearchCounts,
}

/// A chain of edges along which a quarter of index is moved, with the jump changes that do so.
#[derive(Clone, Debug)]
struct Transfer {
    from: VertexId,
    to: VertexId,
    changes: Vec<(EdgeId, i32)>,
    length: f64,
}

impl<'a> Search<'a> {
    /// Starts from given period jumps.
    pub fn new(
        mesh: &'a TriConnectivity,
        transport: &'a Transport,
        length: &'a EdgeMap<f64>,
        system: &'a SmoothnessSystem<'a>,
        group: VertexMap<u32>,
        period_jump: EdgeMap<i32>,
        options: &'a FieldOptions,
    ) -> Self {
        let mut on_curve = VertexMap::filled(mesh.vertex_count(), false);
        options.clear_of.iter().for_each(|&v| on_curve[v] = true);
        let crowded = beside(mesh, &on_curve);
        let mut kept = EdgeMap::filled(mesh.edge_count(), false);
        options.kept.iter().for_each(|&e| kept[e] = true);
        let price = VertexMap::from_fn(mesh.vertex_count(), |v| match mesh.is_boundary_vertex(v) {
            true => 0.0,
            false => options.singularity_cost + if crowded[v] { options.crowding_cost } else { 0.0 },
        });
        let mut search = Self {
            mesh,
            transport,
            length,
            system,
            options,
            kept,
            on_curve,
            crowded,
            group,
            price,
            field: CrossField { angle: FaceMap::filled(0, 0.0), period_jump },
            turn: EdgeMap::filled(mesh.edge_count(), 0.0),
            index: VertexMap::filled(mesh.vertex_count(), 0),
            unit_cost: EdgeMap::filled(mesh.edge_count(), None),
            pair_cost: BTreeMap::new(),
            loop_cost: BTreeMap::new(),
            counts: SearchCounts::default(),
        };
        for v in mesh.vertices() {
            search.index[v] = search.field.index(mesh, transport, v);
        }
        search.solve();
        search
    }

    /// The field as it is now.
    pub fn field(&self) -> &CrossField {
        &self.field
    }

    /// The field as it is now.
    pub fn into_field(self) -> CrossField {
        self.field
    }

    /// Moves and cancels until neither helps.
    pub fn run(&mut self, progress: &Progress) -> Result<(), FieldError> {
        let mut loops = homology_loops(self.mesh, self.length);
        loops.extend(curve_loops(self.mesh, |f| !self.system.is_free(f)));
        loops.retain(|path| path.iter().all(|(e, _)| !self.kept[*e]));
        self.twist_loops(&loops, progress)?;
        // Each round ends with fewer pairs; the limit only guards against rounding errors.
        for _ in 0..20 {
            self.move_singularities(progress)?;
            let joined = self.cancel_pairs(progress)?;
            if !joined && !self.twist_loops(&loops, progress)? {
                break;
            }
        }
        Ok(())
    }

    /// Moves the singularities that the search left on crowded vertices away, along shortest edge paths that avoid
    /// the curves.
    ///
    /// Not at the least energy: the singularity comes to rest in the next ring, where a map has room for it.
    pub fn move_clear(&mut self) {
        let found: Vec<VertexId> = self.mesh.vertices().filter(|&v| self.crowded[v] && self.index[v] != 0).collect();
        for &v in &found {
            let quarters = self.index[v];
            let Some(path) = self.way_out(v) else { continue };
            let mut at = v;
            for e in path {
                let [a, b] = self.mesh.ends(e);
                self.apply(&[(e, if a == at { -quarters } else { quarters })]);
                at = if a == at { b } else { a };
            }
        }
        if !found.is_empty() {
            self.solve();
        }
    }

    /// Edges of a shortest path to a vertex away from the curves without another singularity beside it.
    fn way_out(&self, from: VertexId) -> Option<Vec<EdgeId>> {
        let mut through: BTreeMap<VertexId, EdgeId> = BTreeMap::new();
        let mut queue = std::collections::VecDeque::from([from]);
        while let Some(v) = queue.pop_front() {
            let free = |w: VertexId| w == from || self.index[w] == 0;
            if v != from && !self.crowded[v] && free(v) && self.mesh.neighbours(v).all(free) {
                let (mut path, mut at) = (Vec::new(), v);
                while at != from {
                    let e = through[&at];
                    path.push(e);
                    let [a, b] = self.mesh.ends(e);
                    at = if a == at { b } else { a };
                }
                path.reverse();
                return Some(path);
            }
            if through.len() > WAY_OUT_VERTICES {
                break;
            }
            for e in self.mesh.vertex_edges(v) {
                let [a, b] = self.mesh.ends(e);
                let w = if a == v { b } else { a };
                let open = !self.on_curve[w] && !self.mesh.is_boundary_vertex(w) && w != from && free(w);
                if open && !through.contains_key(&w) && self.is_passable(e) {
                    through.insert(w, e);
                    queue.push_back(w);
                }
            }
        }
        None
    }

    /// Angles and turns from the period jumps.
    fn solve(&mut self) {
        self.field.angle = self.system.angles(&self.field.period_jump);
        self.turn = self.system.turns(&self.field.angle, &self.field.period_jump);
        self.counts.solves += 1;
    }

    /// Changes jumps, and the indices with them.
    fn apply(&mut self, changes: &[(EdgeId, i32)]) {
        for &(e, amount) in changes {
            self.field.period_jump[e] += amount;
            let [a, b] = self.mesh.ends(e);
            // Crossing the canonical half-edge is counter-clockwise around its target.
            self.index[a] += if self.mesh.is_boundary_vertex(a) { 0 } else { amount };
            self.index[b] -= if self.mesh.is_boundary_vertex(b) { 0 } else { amount };
        }
    }

    /// Price of the indices after minus before a change of one edge's jump.
    ///
    /// A pair that appears is a near one: it must gain what joining it may cost, lest pairs come and go for ever.
    fn fee(&self, e: EdgeId, amount: i32) -> f64 {
        let [a, b] = self.mesh.ends(e);
        let (mut fee, mut more) = (0.0, 0);
        for (v, by) in [(a, amount), (b, -amount)] {
            if !self.mesh.is_boundary_vertex(v) {
                let change = (self.index[v] + by).abs() - self.index[v].abs();
                fee += self.price[v] * f64::from(change);
                more += change;
            }
        }
        fee + 0.5 * self.options.near_pair_cost * f64::from(more.max(0))
    }

    /// Whether index may flow along an edge: it is interior and keeps every prescribed sum.
    fn is_passable(&self, e: EdgeId) -> bool {
        let (i, j) = self.mesh.edge_faces(e);
        let [a, b] = self.mesh.ends(e);
        let is_free = j.is_some_and(|j| self.system.is_free(i) || self.system.is_free(j));
        is_free && !self.kept[e] && self.group[a] == self.group[b]
    }
}

/// Single moves.
impl Search<'_> {
    /// Moves singularities along edges while the objective falls.
    ///
    /// 1. With exact angles, all promising moves, best first.
    /// 2. Each is tried with the angles of a patch around it free, taken if the objective falls, and its surroundings
    ///    are looked at again.
    /// 3. Exact angles; again until nothing moves.
    fn move_singularities(&mut self, progress: &Progress) -> Result<(), FieldError> {
        // Every accepted move lowers the objective, so the limit only guards against rounding errors.
        for _ in 0..50 {
            let mut edges = self.moving_edges(self.mesh.edges());
            if edges.is_empty() {
                break;
            }
            let before = self.counts.moves;
            while !edges.is_empty() {
                progress.check()?;
                let mut touched = BTreeSet::new();
                for &(_, e) in &edges {
                    self.try_move(e, &mut touched);
                }
                edges = self.moving_edges(touched.into_iter());
            }
            if self.counts.moves == before {
                break;
            }
            self.solve();
        }
        Ok(())
    }

    /// The edges whose change would lower the objective if angles were stationary, best first.
    fn moving_edges(&mut self, edges: impl Iterator<Item = EdgeId>) -> Vec<(f64, EdgeId)> {
        let mut list = Vec::new();
        for e in edges {
            let turn = self.turn[e].abs();
            if turn < SMALLEST_MOVING_TURN || !self.is_passable(e) {
                continue;
            }
            let linear = self.fee(e, self.direction_of(e)) - PI * turn;
            let change = linear + if linear < 0.0 { self.unit_cost(e) } else { 0.0 };
            if change < -LEAST_GAIN {
                list.push((change, e));
            }
        }
        list.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        list
    }

    /// The change of an edge's jump that its turn asks for.
    fn direction_of(&self, e: EdgeId) -> i32 {
        if self.turn[e] > 0.0 { 1 } else { -1 }
    }

    /// Changes the jump of an edge if that lowers the objective, with the angles of a patch around it free.
    fn try_move(&mut self, e: EdgeId, touched: &mut BTreeSet<EdgeId>) {
        let amount = self.direction_of(e);
        let patch = Patch::around(self.mesh, self.system, e);
        let shift = FRAC_PI_2 * f64::from(amount);
        let before = self.turn[e];
        self.turn[e] -= shift;
        let mut x: Vec<f64> = patch.faces.iter().map(|&f| self.force(f)).collect();
        let force = x.clone();
        patch.solve(&mut x);
        let gain: f64 = x.iter().zip(&force).map(|(x, force)| x * force).sum();
        let change = self.turn[e].powi(2) - before.powi(2) - gain + self.fee(e, amount);
        if change > -LEAST_GAIN {
            self.turn[e] = before;
            return;
        }
        self.apply(&[(e, amount)]);
        self.counts.moves += 1;
        for (&f, x) in patch.faces.iter().zip(x) {
            self.field.angle[f] += x;
        }
        for &f in &patch.faces {
            for h in self.mesh.face_half_edges(f) {
                let side = self.mesh.edge(h);
                self.turn[side] = self.field.turn(self.mesh, self.transport, self.mesh.half_edge(side));
                touched.insert(side);
            }
        }
    }

    /// Half the energy's fall per radian of a face's angle.
    fn force(&self, f: FaceId) -> f64 {
        let out = |h| {
            let e = self.mesh.edge(h);
            if self.mesh.half_edge(e) == h { self.turn[e] } else { -self.turn[e] }
        };
        self.mesh.face_half_edges(f).into_iter().map(out).sum::<f64>() + self.system.soft_pull(f, self.field.angle[f]).1
    }

    /// Q of a unit change of an edge's jump with the angles of a patch around it free: an upper bound of Q.
    fn unit_cost(&mut self, e: EdgeId) -> f64 {
        if let Some(cost) = self.unit_cost[e] {
            return cost;
        }
        let patch = Patch::around(self.mesh, self.system, e);
        let (i, j) = self.mesh.edge_faces(e);
        let unit = |f: FaceId| f64::from(u8::from(Some(f) == j)) - f64::from(u8::from(f == i));
        let mut x: Vec<f64> = patch.faces.iter().map(|&f| FRAC_PI_2 * unit(f)).collect();
        patch.solve(&mut x);
        let response: f64 = patch.faces.iter().zip(&x).map(|(&f, x)| unit(f) * x).sum();
        let cost = FRAC_PI_2 * (FRAC_PI_2 - response);
        self.unit_cost[e] = Some(cost);
        cost
    }
}

/// Cancellation of pairs.
impl Search<'_> {
    /// Joins opposite pairs along shortest paths, cheapest first; whether any was joined.
    fn cancel_pairs(&mut self, progress: &Progress) -> Result<bool, FieldError> {
        // 1. Pairs that may pay, by the estimate of a regular triangulation.
        let mut pairs = self.opposite_pairs();
        pairs.retain(|t| self.estimated_change(t) < self.allowance(t) + ESTIMATE_MARGIN);
        // 2. Their exact costs, unless known from an earlier round.
        self.compute_costs(&pairs, progress)?;
        // 3. Join the cheapest until none pays: only the linear part of a change depends on the others.
        let mut joined = false;
        loop {
            let change = |t: &Transfer| self.linear_change(t) + self.pair_cost[&(t.from, t.to)] - self.allowance(t);
            let best = pairs.iter().enumerate().map(|(k, t)| (change(t), k)).min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, k)) = best.filter(|&(change, _)| change < -LEAST_GAIN) else { break };
            progress.check()?;
            let transfer = pairs.swap_remove(k);
            self.apply(&transfer.changes);
            self.solve();
            self.counts.cancelled_pairs += 1;
            joined = true;
            pairs.retain(|t| self.index[t.from] > 0 && self.index[t.to] < 0);
        }
        Ok(joined)
    }

    /// Q of every path that is not known yet, eight right-hand sides at a time.
    fn compute_costs(&mut self, pairs: &[Transfer], progress: &Progress) -> Result<(), FieldError> {
        let unknown: Vec<&Transfer> = pairs.iter().filter(|t| !self.pair_cost.contains_key(&(t.from, t.to))).collect();
        for batch in unknown.chunks(8) {
            progress.check()?;
            let changes: Vec<&[(EdgeId, i32)]> = batch.iter().map(|t| t.changes.as_slice()).collect();
            let responses = self.system.responses(&changes);
            self.counts.solves += batch.len();
            for (column, transfer) in batch.iter().enumerate() {
                let cost = self.cost_of(&transfer.changes, |f| self.system.change(&responses, column, f));
                self.pair_cost.insert((transfer.from, transfer.to), cost);
            }
        }
        Ok(())
    }

    /// Rise of the energy at which a pair is still joined.
    fn allowance(&self, transfer: &Transfer) -> f64 {
        let near = if transfer.length <= self.options.cancel_distance { self.options.near_pair_cost } else { 0.0 };
        self.price[transfer.from] + self.price[transfer.to] + near
    }

    /// Change of the energy if the path's cost were that of a regular triangulation.
    ///
    /// Q is (π/2)² times the effective resistance between the ends, (ln d + γ + ln(12)/2) / (√3·π) at d edges.
    fn estimated_change(&self, transfer: &Transfer) -> f64 {
        let hops = transfer.changes.len() as f64;
        let resistance = (hops.ln() + 1.8197) / (3f64.sqrt() * PI);
        self.linear_change(transfer) + FRAC_PI_2 * FRAC_PI_2 * resistance
    }

    fn linear_change(&self, transfer: &Transfer) -> f64 {
        -PI * self.linear_turn(&transfer.changes)
    }

    /// Q of a set of changes, given the angles' response to them.
    fn cost_of(&self, changes: &[(EdgeId, i32)], x: impl Fn(FaceId) -> f64) -> f64 {
        let cost = |&(e, amount): &(EdgeId, i32)| {
            let (i, j) = self.mesh.edge_faces(e);
            let response = j.map_or(0.0, |j| x(j) - x(i));
            f64::from(amount) * (FRAC_PI_2 * f64::from(amount) - response)
        };
        FRAC_PI_2 * changes.iter().map(cost).sum::<f64>()
    }

    /// Shortest paths from every positive singularity to the negative ones within reach, at most four each.
    fn opposite_pairs(&self) -> Vec<Transfer> {
        let mut transfers = Vec::new();
        let mut distance = VertexMap::filled(self.mesh.vertex_count(), f64::INFINITY);
        let mut via: VertexMap<Option<EdgeId>> = VertexMap::filled(self.mesh.vertex_count(), None);
        for from in self.mesh.vertices().filter(|&v| self.index[v] > 0) {
            let mut reached = vec![from];
            distance[from] = 0.0;
            let mut heap = BinaryHeap::from([Reverse((Key(0.0), from.0))]);
            let mut found = 0;
            while let Some(Reverse((Key(d), v))) = heap.pop() {
                let v = VertexId(v);
                if d > distance[v] {
                    continue;
                }
                if self.index[v] < 0 && self.group[v] == self.group[from] {
                    transfers.push(self.transfer(from, v, &via, d));
                    found += 1;
                    if found == 4 {
                        break;
                    }
                }
                for e in self.mesh.vertex_edges(v) {
                    let next = d + self.length[e];
                    if next > self.options.reach || !self.is_crossable(e) {
                        continue;
                    }
                    let [a, b] = self.mesh.ends(e);
                    let w = if a == v { b } else { a };
                    if next < distance[w] {
                        if distance[w] == f64::INFINITY {
                            reached.push(w);
                        }
                        distance[w] = next;
                        via[w] = Some(e);
                        heap.push(Reverse((Key(next), w.0)));
                    }
                }
            }
            for v in reached {
                distance[v] = f64::INFINITY;
                via[v] = None;
            }
        }
        transfers
    }

    /// Whether an edge's jump is free to change, whatever the groups of its ends.
    fn is_crossable(&self, e: EdgeId) -> bool {
        let (i, j) = self.mesh.edge_faces(e);
        !self.kept[e] && j.is_some_and(|j| self.system.is_free(i) || self.system.is_free(j))
    }

    fn transfer(&self, from: VertexId, to: VertexId, via: &VertexMap<Option<EdgeId>>, length: f64) -> Transfer {
        let (mut changes, mut at) = (Vec::new(), to);
        while let Some(e) = via[at] {
            let [a, b] = self.mesh.ends(e);
            // Index leaves the origin of the canonical half-edge when its jump falls.
            changes.push((e, if at == b { -1 } else { 1 }));
            at = if at == b { a } else { b };
        }
        Transfer { from, to, changes, length }
    }
}

/// Twists around handles and tubes.
impl Search<'_> {
    /// Turns the field by a quarter more or less around loops that no singularity can cross, while the energy falls;
    /// whether it did. Indices do not change.
    fn twist_loops(&mut self, loops: &[Vec<(EdgeId, i32)>], progress: &Progress) -> Result<bool, FieldError> {
        let gain = |search: &Self, k: usize| PI * search.linear_turn(&loops[k]).abs();
        // 1. Exact costs of the loops along which there is something to gain.
        for batch in (0..loops.len()).filter(|&k| gain(self, k) > LEAST_TWIST).collect::<Vec<_>>().chunks(8) {
            progress.check()?;
            let unknown: Vec<usize> = batch.iter().copied().filter(|k| !self.loop_cost.contains_key(k)).collect();
            let changes: Vec<&[(EdgeId, i32)]> = unknown.iter().map(|&k| loops[k].as_slice()).collect();
            let responses = self.system.responses(&changes);
            self.counts.solves += unknown.len();
            for (column, &k) in unknown.iter().enumerate() {
                let cost = self.cost_of(&loops[k], |f| self.system.change(&responses, column, f));
                self.loop_cost.insert(k, cost);
            }
        }
        // 2. The best twist, until none helps.
        let mut twisted = false;
        loop {
            let known = self.loop_cost.iter().map(|(&k, &cost)| (cost - gain(self, k), k));
            let Some((change, k)) = known.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) else { break };
            if change > -LEAST_GAIN {
                break;
            }
            progress.check()?;
            let sign = if self.linear_turn(&loops[k]) > 0.0 { 1 } else { -1 };
            let changes: Vec<(EdgeId, i32)> = loops[k].iter().map(|&(e, amount)| (e, sign * amount)).collect();
            self.apply(&changes);
            self.solve();
            self.counts.twists += 1;
            twisted = true;
        }
        Ok(twisted)
    }

    /// Σ δ_e t_e.
    fn linear_turn(&self, changes: &[(EdgeId, i32)]) -> f64 {
        changes.iter().map(|&(e, amount)| f64::from(amount) * self.turn[e]).sum()
    }
}

/// A finite number ordered by value.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Key(pub f64);

impl Eq for Key {}
impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Key {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
