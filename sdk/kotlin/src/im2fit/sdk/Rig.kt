// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/**
 * A pose for the nodes of an avatar's .glb, in the order and axes of the file: y up, metres, the lower foot at y = 0. Node i
 * is entry i of [rigNodes].
 *
 * @property root x y z, the translation of node 0
 * @property rotations four numbers per node: x y z w of a unit quaternion, relative to the parent
 * @property userId the tracked person
 * @property inferred joints that are not visible and therefore inferred
 */
class Rig(val root: FloatArray, val rotations: FloatArray, val userId: Int, val inferred: Set<JointName>) {
    companion object {
        const val NODE_COUNT = 19
    }
}

/** A node of the avatar: its name in the .glb, and the index of its parent in [rigNodes]; -1 for the first. */
data class RigNode(val name: String, val parent: Int)

/** The nodes that a [Rig] moves. */
fun rigNodes(): List<RigNode> {
    val names = arrayOfNulls<ByteArray>(Rig.NODE_COUNT)
    val parents = IntArray(Rig.NODE_COUNT)
    Native.rigNodes(names, parents)
    return names.zip(parents.toList()) { name, parent -> RigNode(Native.text(name)!!, parent) }
}
