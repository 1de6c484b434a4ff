//! Trees in level order: the nodes of every level lie together, the root's first.
//!
//! An update that exchanges nodes across subtrees cannot go by disjoint subtrees, as the refit does. By levels it can, from the last one
//! upwards: the nodes of a level are independent of each other, and their children are all in the level below. Exchanges that
//! keep every node's depth keep the order, the depth of the tree, and that children have higher numbers than parents.

use super::bvh::{Bvh, ChildRef, Node8, OutOfMemory};
use super::memory::reserve;

impl Bvh {
    pub(super) fn is_in_level_order(&self) -> bool {
        !self.levels.is_empty()
    }

    /// The same tree in level order. It has no subtrees for [`Bvh::refit`] to work on in parallel.
    pub(super) fn in_level_order(mut self) -> Result<Bvh, OutOfMemory> {
        self.levels.clear();
        let mut nodes: Vec<Node8> = reserve(self.nodes.len())?;
        nodes.extend(self.nodes.first());
        let mut begin = 0;
        while begin < nodes.len() {
            self.levels.push(begin);
            let end = nodes.len();
            for parent in begin..end {
                for lane in 0..nodes[parent].child_count() {
                    let child = nodes[parent].children[lane];
                    if !child.is_leaf() {
                        nodes[parent].children[lane] = ChildRef::node(nodes.len());
                        nodes.push(self.nodes[child.index()]);
                    }
                }
            }
            begin = end;
        }
        self.nodes = nodes;
        self.subtrees = Vec::new();
        Ok(self)
    }
}
