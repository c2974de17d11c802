// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

import java.io.Closeable
import java.util.concurrent.locks.ReentrantReadWriteLock
import kotlin.concurrent.read
import kotlin.concurrent.write

/**
 * One person before one depth camera. Opening loads the models and starts the threads, which takes some tens of
 * milliseconds; [close] frees all of it.
 *
 * Threads: all functions may be called from any thread. [push] and what changes the session take turns; [progress]
 * never waits for them, so that a screen may ask while frames arrive. [close] waits until the others have returned;
 * after it they throw IllegalStateException.
 *
 * @throws Im2fitException a model is missing, damaged or of another version, or a setting is out of range
 */
class Session @JvmOverloads constructor(
    private val camera: Camera, models: Models, private val settings: Settings = Settings()
) : Closeable {
    private var handle = open(camera.upright(), models, settings)
    private val open = ReentrantReadWriteLock() // for writing: the handle goes
    private val turn = Any()
    private val numbers = IntArray(5)
    private val longs = LongArray(7)
    private val floats = FloatArray(20)

    /** Hands over one frame; it is copied. With [Settings.live] false it waits while the library is behind. */
    fun push(frame: Frame) {
        val of = frame.camera ?: camera
        require(of.rotateDeg == camera.rotateDeg) { "a frame cannot be turned otherwise than its session" }
        frame.checkSize(of.width, of.height)
        change {
            intArrayOf(frame.format.ordinal, of.width, of.height, of.rotateDeg, frame.confidenceMin).copyInto(numbers)
            longs[0] = frame.pixels.position().toLong()
            longs[1] = frame.rowBytes.toLong()
            longs[2] = (frame.confidence?.position() ?: 0).toLong()
            longs[3] = frame.confidenceRowBytes.toLong()
            longs[4] = frame.sequence
            longs[5] = frame.timeNs
            longs[6] = -1
            floats[0] = frame.unitMm
            floats[1] = of.fx
            floats[2] = of.fy
            floats[3] = of.cx
            floats[4] = of.cy
            floats[5] = frame.down?.x ?: 0f
            floats[6] = frame.down?.y ?: 0f
            floats[7] = frame.down?.z ?: 0f
            floats[8] = of.lens.k1
            floats[9] = of.lens.k2
            floats[10] = of.lens.k3
            floats[11] = of.lens.p1
            floats[12] = of.lens.p2
            floats[13] = frame.pose?.x ?: 0f
            floats[14] = frame.pose?.y ?: 0f
            floats[15] = frame.pose?.z ?: 0f
            floats[16] = frame.pose?.w ?: 0f
            floats[17] = frame.pose?.xMm ?: 0f
            floats[18] = frame.pose?.yMm ?: 0f
            floats[19] = frame.pose?.zMm ?: 0f
            Native.push(it, frame.pixels, frame.confidence, numbers, longs, floats)
        }
    }

    /** Where the session stands; never waits for the threads at work. */
    fun progress(): Progress = result().progress()

    /**
     * Pushes [frames] as they are taken from the sequence, until the measurement, and gives the session's state each time
     * the person is to be told something else. Nothing happens before the result is iterated over.
     */
    fun states(frames: Sequence<Frame>): Sequence<Progress> = sequence {
        var before: Progress? = null
        for (frame in frames) {
            push(frame)
            val now = progress()
            if (now.saysMoreThan(before)) yield(now)
            before = now
            if (now.state == State.MEASURED) break
        }
    }

    /** All of it: [states] to [told], then [finish]. */
    @JvmOverloads
    fun measure(frames: Sequence<Frame>, told: (Progress) -> Unit = {}): Outcome {
        states(frames).forEach(told)
        return finish()
    }

    /** Waits until every frame pushed has been processed. False after [timeoutMs]; negative: no limit. */
    fun await(timeoutMs: Int = -1): Boolean {
        val status = turn { Native.act(it, Native.DO_WAIT, timeoutMs) }
        if (status == TIMEOUT) return false
        check(status)
        return true
    }

    /** No more frames: measures with what there is. Fine to call again. */
    fun finish(): Outcome {
        change { Native.act(it, Native.DO_FINISH, 0) }
        return outcome()
    }

    /** What [finish] gave, or what stands when [progress] says MEASURED. */
    fun outcome(): Outcome {
        val result = result()
        if (!result.measured) return Outcome.NotMeasured(result.state, result.guidanceSeen)
        return Outcome.Measured(result.person(size()))
    }

    /** A new person: forgets everything seen. */
    fun reset() = change { Native.act(it, Native.DO_RESET, 0) }

    /** The next person, after MEASURED: begins by itself when the one measured has left the picture. */
    fun next() = change { Native.act(it, Native.DO_NEXT, 0) }

    /** Only the person of this [Progress.userId] from now on; 0: whoever stands right first. */
    fun selectUser(userId: Int) = change { Native.act(it, Native.DO_SELECT_USER, userId) }

    /** result.json (docs/result.md), whether measured or not. */
    fun json(): String = String(bytes(Native.BYTES_JSON), Charsets.UTF_8)

    /** The bytes of the person's avatar. Needs a measurement and [Models.body], as do [mesh] and [tape]. */
    fun avatar(format: Avatar): ByteArray = bytes(format.ordinal)

    /** The person as a mesh in the measured pose. */
    fun mesh(): Mesh = turn { handle ->
        val counted = IntArray(2)
        check(Native.mesh(handle, null, null, counted))
        val mesh = Mesh(FloatArray(3 * counted[0]), IntArray(3 * counted[1]))
        check(Native.mesh(handle, mesh.vertices, mesh.triangles, counted))
        mesh
    }

    /** All of the tape for the person, by id, in the order of [tapeDefinitions]. */
    fun tape(): Map<String, TapeValue> {
        val ids = tapeDefinitions().map { it.id }
        val statuses = IntArray(ids.size)
        val values = FloatArray(3 * ids.size)
        val reasons = arrayOfNulls<ByteArray>(ids.size)
        change { Native.tape(it, statuses, values, reasons) }
        return ids.withIndex().associate { (i, id) ->
            id to if (statuses[i] == 0) {
                TapeValue.Measured(Estimate(values[3 * i], values[3 * i + 1], values[3 * i + 2]))
            } else {
                TapeValue.Refused(Native.text(reasons[i]) ?: "")
            }
        }
    }

    /**
     * How each size of a garment ([garments]' id) sits on the person. Needs a measurement and [Models.body], as do
     * [dressedAvatar] and [rig].
     */
    fun fit(garment: String): GarmentFit {
        val sizes = arrayOfNulls<ByteArray>(Native.SIZES_MAX)
        val places = arrayOfNulls<ByteArray>(Native.PLACES_MAX)
        val floats = FloatArray(Native.SIZES_MAX * (1 + 3 * Native.PLACES_MAX))
        val verdicts = IntArray(Native.SIZES_MAX * Native.PLACES_MAX)
        val counted = IntArray(3)
        change { Native.fit(it, arrayOf(garment.toByteArray()), sizes, places, floats, verdicts, counted) }
        val (count, best, placeCount) = counted
        val names = (0 until placeCount).map { Native.text(places[it])!! }
        val fits = (0 until count).map { i ->
            val at = i * (1 + 3 * placeCount)
            SizeFit(Native.text(sizes[i])!!, floats[at], names.withIndex().associate { (r, name) ->
                val ease = Estimate(floats[at + 1 + 3 * r], floats[at + 2 + 3 * r], floats[at + 3 + 3 * r])
                name to PlaceFit(ease, Fit.values()[verdicts[i * placeCount + r]])
            })
        }
        return GarmentFit(fits, fits[best])
    }

    /** The person's .glb, dressed, what lies on the skin first; of nothing: in trousers and a T-shirt of the best sizes. */
    @JvmOverloads
    fun dressedAvatar(worn: List<Worn> = emptyList()): ByteArray {
        require(worn.size <= Native.WORN_MAX) { "${worn.size} garments, expected at most ${Native.WORN_MAX}" }
        val made = arrayOfNulls<ByteArray>(1)
        val ids = Array<ByteArray?>(worn.size) { worn[it].garment.toByteArray() }
        val sizes = Array(worn.size) { worn[it].size?.toByteArray() }
        change { Native.dressed(it, ids, sizes, made) }
        return made[0]!!
    }

    /**
     * How the avatar stands as the person does in the latest frame; null when no person is followed there. It moves once
     * [next] lets frames in again, until the next person's session begins.
     */
    fun rig(): Rig? = turn { handle ->
        val floats = FloatArray(3 + 4 * Rig.NODE_COUNT)
        val numbers = IntArray(2)
        val status = Native.rig(handle, floats, numbers)
        if (status == NOT_FOUND) return@turn null
        check(status)
        Rig(floats.copyOf(3), floats.copyOfRange(3, floats.size), numbers[0], bitsOf(numbers[1].toLong()))
    }

    /** What the session was opened with. */
    fun modelInfo(): ModelInfo = turn { handle ->
        val n = LongArray(8)
        val texts = arrayOfNulls<ByteArray>(1)
        check(Native.models(handle, n, texts))
        ModelInfo(Native.text(texts[0])!!, n[0], n[1], n[2], n[3] != 0L, n[4] != 0L, n[5] != 0L, n[6] != 0L, n[7] != 0L)
    }

    /** Stops the threads and frees everything; frames in the pipeline are given up. Fine to call again. */
    override fun close() = open.write {
        if (handle != 0L) Native.close(handle)
        handle = 0
    }

    private fun size(): Size {
        val names = arrayOfNulls<ByteArray>(Native.SIZES_MAX)
        val probabilities = FloatArray(Native.SIZES_MAX)
        val counted = IntArray(2)
        change { Native.sizes(it, names, probabilities, counted) }
        val known = (0 until counted[0]).map { Native.text(names[it])!! to probabilities[it] }
        return Size(known[counted[1]].first, known.toMap(LinkedHashMap()))
    }

    private fun bytes(what: Int): ByteArray {
        val made = arrayOfNulls<ByteArray>(1)
        change { Native.bytes(it, what, made) }
        return made[0]!!
    }

    private fun result(): Result = open.read {
        val result = Result()
        check(Native.poll(alive(), result.longs, result.floats))
        result
    }

    private fun alive(): Long = handle.also { check(it != 0L) { "the session is closed" } }
    private inline fun <T> turn(what: (Long) -> T): T = open.read { synchronized(turn) { what(alive()) } }
    // The text of a failure is the latest call's: read before another thread's turn.
    private inline fun change(what: (Long) -> Int) = turn { check(what(it)) }
    private fun check(status: Int) {
        if (status == Native.OK) return
        val text = Native.text(Native.lastError(handle)).orEmpty()
        // Native.poll leaves the handle's text alone; the thread has its own.
        throw Im2fitException(status, if (text != "") text else Native.text(Native.lastError(0)).orEmpty())
    }

    private companion object {
        const val NOT_FOUND = -2
        const val TIMEOUT = -7

        fun open(camera: Camera, models: Models, settings: Settings): Long {
            val files = listOf(models.tracker, models.index, models.body)
            val paths = files.map { (it as? ModelFile.Path)?.file?.path?.toByteArray() } + listOf(null, null)
            val contents = files.map { (it as? ModelFile.Bytes)?.bytes }
            val parts = files.map { it as? ModelFile.Descriptor }
            val numbers = intArrayOf(
                camera.width, camera.height, settings.framesWanted, settings.framesMin, settings.calibrationPose.toInt(),
                settings.live.toInt(), settings.singleThread.toInt(), settings.turn.toInt(), settings.clothing.ordinal,
                settings.sensor.ordinal, 0
            )
            val opened = LongArray(1)
            val status = Native.open(
                paths.toTypedArray(), contents.toTypedArray(), IntArray(3) { parts[it]?.fd ?: -1 },
                LongArray(3) { parts[it]?.offset ?: 0 }, LongArray(3) { parts[it]?.length ?: 0 }, numbers,
                floatArrayOf(camera.fx, camera.fy, camera.cx, camera.cy), opened
            )
            if (status != Native.OK) throw Im2fitException(status, Native.text(Native.lastError(0)).orEmpty())
            return opened[0]
        }

        fun Boolean.toInt(): Int = if (this) 1 else 0
    }
}
