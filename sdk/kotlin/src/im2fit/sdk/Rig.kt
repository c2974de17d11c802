// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/**
 * How the nodes of an avatar's .glb are to stand so that it does what the person does: in the file's order and axes (y up,
 * metres, the lower foot on y = 0). Node i is [rigNodes]' i.
 *
 * @property root x y z, the translation of node 0
 * @property rotations of each node four numbers, x y z w of a unit quaternion relative to its parent
 * @property userId whose joints these are
 * @property inferred joints that are not seen, where the pose is a guess
 */
class Rig(val root: FloatArray, val rotations: FloatArray, val userId: Int, val inferred: Set<JointName>) {
    companion object {
        const val NODE_COUNT = 19
    }
}

/** A node of the avatar: its name in the .glb, and its parent's place in [rigNodes], -1 of the first. */
data class RigNode(val name: String, val parent: Int)

/** The nodes that a [Rig] moves. */
fun rigNodes(): List<RigNode> {
    val names = arrayOfNulls<ByteArray>(Rig.NODE_COUNT)
    val parents = IntArray(Rig.NODE_COUNT)
    Native.rigNodes(names, parents)
    return names.zip(parents.toList()) { name, parent -> RigNode(Native.text(name)!!, parent) }
}
