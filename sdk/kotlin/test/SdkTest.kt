// SPDX-License-Identifier: Apache-2.0
// The package on a real virtual machine: scripts/kotlin-test runs this under -Xcheck:jni. Arguments: the folder of
// tests/golden/data, a folder with the models' names, and pairs of a depth folder and what `im2fit measure --json` says
// of it. A failed expectation ends the program with 1.
package im2fit.sdk.test

import im2fit.sample.states
import im2fit.sdk.*
import java.awt.image.DataBufferUShort
import java.io.File
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.concurrent.atomic.AtomicBoolean
import java.util.concurrent.atomic.AtomicLong
import javax.imageio.ImageIO
import kotlin.concurrent.thread
import kotlin.coroutines.Continuation
import kotlin.coroutines.EmptyCoroutineContext
import kotlin.coroutines.startCoroutine
import kotlin.math.abs
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.flow.flow

class Clip(folder: File) {
    private val yaml = File(folder, "camera.yaml").readText()
    private val k = Regex("camera_matrix:.*?data: \\[([^]]*)]", RegexOption.DOT_MATCHES_ALL).find(yaml)!!
        .groupValues[1].split(",").map { it.trim().toFloat() }
    private val rotate = Regex("im2fit_rotate_deg: (\\d+)").find(yaml)?.groupValues?.get(1)?.toInt() ?: 0
    private fun number(key: String) = Regex("$key: (\\d+)").find(yaml)!!.groupValues[1].toInt()
    // OpenCV's order in the file: k1 k2 p1 p2 k3.
    private val lens = Regex("distortion_coefficients:.*?data: \\[([^]]*)]", RegexOption.DOT_MATCHES_ALL).find(yaml)
        ?.groupValues?.get(1)?.split(",")?.map { it.trim().toFloat() }?.let { Lens(it[0], it[1], it[4], it[2], it[3]) } ?: Lens()
    val camera = CameraModel(number("image_width"), number("image_height"), k[0], k[4], k[2], k[5], rotate, lens)
    val depth: List<ShortArray> = folder.listFiles()!!.filter { it.name.endsWith(".png") }.sorted().map {
        (ImageIO.read(it).raster.dataBuffer as DataBufferUShort).data
    }
    // As `im2fit measure` times a folder without timestamps.csv; the golden clip's are the same to the nanosecond's tens.
    fun timeNs(number: Int) = number * 1_000_000_000L / 30
    fun frames(): Sequence<DepthFrame> = depth.asSequence().mapIndexed { i, mm ->
        DepthFrame.ofMillimetres(mm, timeNs(i), i.toLong())
    }
}

val ran = mutableListOf<String>()
fun test(name: String, body: () -> Unit) {
    body()
    ran += name
}

fun expect(truth: Boolean, what: () -> String) {
    if (!truth) throw AssertionError(what())
}

fun <T> same(found: T, expected: T, what: String) = expect(found == expected) { "$what is $found, expected $expected" }

inline fun <reified T : Throwable> fails(body: () -> Unit): T {
    try {
        body()
    } catch (caught: Throwable) {
        if (caught is T) return caught
        throw caught
    }
    throw AssertionError("nothing was thrown, expected ${T::class.java.simpleName}")
}

val quick = Settings(framesWanted = 6, framesMin = 5, live = false)

fun main(arguments: Array<String>) {
    val golden = File(arguments[0])
    val models = Models.of(File(arguments[1]))
    val clip = Clip(File(golden, "clip"))

    test("names are the library's") {
        for ((list, found) in listOf(1 to State.values().map { it.name }, 2 to Guidance.values().map { it.name },
                                     3 to Measurement.values().map { it.id }, 4 to Measurement.values().map { it.unit },
                                     5 to JointName.values().map { it.name })) {
            val native = Class.forName("im2fit.sdk.Native").getMethod("name", Int::class.java, Int::class.java)
            val library = generateSequence(0) { it + 1 }.map { native.invoke(null, list, it) as ByteArray? }
                .takeWhile { it != null }.map { String(it!!) }.toList()
            same(found, library, "list $list")
        }
    }
    test("a diagnosis of a newer library is unknown") {
        same(DiagnosisCode.of(8), DiagnosisCode.UNIT, "code 8")
        for (code in listOf(-1, DiagnosisCode.UNKNOWN.ordinal, 99)) same(DiagnosisCode.of(code), DiagnosisCode.UNKNOWN, "code $code")
    }
    test("failures have a status and a text") {
        val missing = fails<Im2fitException> {
            FitSession(clip.camera, Models(ModelFile.Path(File("/nonexistent.i2t")), models.index)).close()
        }
        expect(missing.statusName in listOf("not_found", "io") && "nonexistent" in missing.message!!) { "$missing" }
        val wrong = fails<Im2fitException> { FitSession(clip.camera, models, Settings(framesWanted = 0)).close() }
        same(wrong.statusName, "invalid_argument", "no frames wanted")
        fails<IllegalArgumentException> { CameraModel(1, 1, 1f, 1f, 0f, 0f, rotateDeg = 45) }
        fails<IllegalArgumentException> { Models.of(File("/nonexistent")) }
        fails<IllegalArgumentException> { DepthFrame(ByteBuffer.allocate(4), DepthFormat.U16) }
        fails<IllegalArgumentException> { tapeDefinitions("xx") }
    }
    test("short buffers never reach the library") {
        FitSession(clip.camera, models, quick).use { session ->
            fails<IllegalArgumentException> { session.push(DepthFrame.ofMillimetres(ShortArray(320 * 240 - 1))) }
            val plane = ByteBuffer.allocateDirect(320 * 240 * 2)
            fails<IllegalArgumentException> { session.push(DepthFrame(plane, DepthFormat.U16, rowBytes = 642)) }
            fails<IllegalArgumentException> { session.push(DepthFrame(plane, DepthFormat.F32)) }
            val odd = fails<Im2fitException> { session.push(DepthFrame(plane, DepthFormat.U16, unitMm = -1f)) }
            expect("unit_mm" in odd.message!!) { "$odd" }
        }
    }
    test("an empty room is not measured") {
        FitSession(clip.camera, models, quick).use { session ->
            val states = mutableListOf<Progress>()
            val room = generateSequence { DepthFrame.ofMillimetres(ShortArray(320 * 240)) }.take(3)
            val outcome = session.measure(room) { states += it }
            expect(outcome is Outcome.NotMeasured && Guidance.NO_PERSON in outcome.guidance) { "$outcome" }
            same(states.last().state, State.SEARCHING, "state")
            same(fails<Im2fitException> { session.mesh() }.statusName, "not_measured", "mesh without a person")
        }
    }
    for ((folder, output) in arguments.drop(2).chunked(2)) {
        test("$folder measures as im2fit does") { measuresAsProgram(Clip(File(folder)), models, File(output).readText()) }
    }
    test("metres, millimetres and DEPTH16 are one person") {
        val half = ByteOrder.nativeOrder()
        val metres = clip.depth.asSequence().mapIndexed { i, mm ->
            DepthFrame.ofMetres(FloatArray(mm.size) { mm[it] / 1000f }, clip.timeNs(i), i.toLong())
        }
        val depth16 = clip.depth.asSequence().mapIndexed { i, mm -> // a row longer than the picture, confidence in the top bits
            val buffer = ByteBuffer.allocateDirect(240 * 700).order(half)
            for (y in 0 until 240) for (x in 0 until 320) {
                val z = mm[y * 320 + x].toInt() and 0xffff
                buffer.putShort(y * 700 + 2 * x, (if (z < 8192) z else 0).toShort())
            }
            DepthFrame(buffer, DepthFormat.DEPTH16, rowBytes = 700, timeNs = clip.timeNs(i), sequence = i.toLong())
        }
        val people = listOf(clip.frames(), metres, depth16).map { frames ->
            FitSession(clip.camera, models, quick).use { it.measure(frames) }
        }
        expect(people[0] is Outcome.Measured) { "${people[0]}" }
        same(people[1], people[0], "in metres")
        same(people[2], people[0], "as DEPTH16")
    }
    test("gravity") {
        // Held upright, y of the sensor points up the screen: down is down the upright picture, and where that lies in a
        // frame the camera delivers on its side.
        val upright = floatArrayOf(0f, 9.81f, 0f)
        same(Direction.ofAndroidGravity(upright, 0), Direction(-0f, 9.81f, 0f), "no turn")
        same(Direction.ofAndroidGravity(upright, 90), Direction(9.81f, 0f, 0f), "by 90 degrees")
        same(Direction.ofAndroidGravity(upright, 270), Direction(-9.81f, -0f, 0f), "by 270 degrees")
        // Tilted forward, its back looks down: forward has a share of down.
        expect(Direction.ofAndroidGravity(floatArrayOf(0f, 9f, 3f), 90).z > 0) { "looking down" }
        FitSession(clip.camera, models, quick).use { session ->
            val still = clip.frames().first()
            session.push(DepthFrame(still.pixels, still.format, down = Direction(9.81f, 0f, 0f)))
            val bad = fails<Im2fitException> {
                session.push(DepthFrame(still.pixels, still.format, down = Direction(Float.NaN, 0f, 0f)))
            }
            expect("down_x" in bad.message!!) { "$bad" }
        }
    }
    test("garments and nodes have names") {
        same(garments().map { it.id }.toSet(), setOf("dress", "long_sleeved_shirt", "shorts", "skirt", "t_shirt", "trousers"), "ids")
        same(garments("de").first { it.id == "trousers" }.name, "Hose", "in German")
        fails<IllegalArgumentException> { garments("xx") }
        same(rigNodes().first(), RigNode("pelvis", -1), "the first node")
        FitSession(clip.camera, models, quick).use { session ->
            val info = session.modelInfo()
            expect(info.people in 1..info.captures && info.madeBy.isNotEmpty()) { "$info" }
            expect(info.hasBody && !info.siteCorrected) { "$info" }
            same(fails<Im2fitException> { session.rig() }.statusName, "not_measured", "rig")
            same(fails<Im2fitException> { session.fit("t_shirt") }.statusName, "not_measured", "fit")
            same(fails<Im2fitException> { session.dressedAvatar() }.statusName, "not_measured", "dressed")
        }
    }
    test("a camera in the hand") {
        // ARCore looks along -z with y up: its identity is a half turn about x in our axes.
        val identity = CameraPose.ofArCore(floatArrayOf(0f, 0f, 0f, 1f), floatArrayOf(1f, 2f, 3f))
        same(identity, CameraPose(1f, 0f, -0f, -0f, 1000f, 2000f, 3000f), "ARCore")
        fun posed(pose: CameraPose) = clip.frames().map {
            DepthFrame(it.pixels, it.format, timeNs = it.timeNs, sequence = it.sequence, pose = pose)
        }
        val still = FitSession(clip.camera, models, quick).use { it.measure(clip.frames()) }
        // Wherever a camera is that does not move, its frames are taken as they are.
        val held = CameraPose(0.5f, -0.5f, 0.5f, 0.5f, 10f, 20f, 30f)
        same(FitSession(clip.camera, models, quick).use { it.measure(posed(held)) }, still, "a camera at rest")
        // Each number reaches the library: a single one that is not a number is refused.
        fun bad(at: Int) = FloatArray(7) { if (it == at) Float.NaN else if (it == 3) 1f else 0f }
            .let { CameraPose(it[0], it[1], it[2], it[3], it[4], it[5], it[6]) }
        for (at in 0 until 7) FitSession(clip.camera, models, quick).use { session ->
            val found = fails<Im2fitException> { session.push(posed(bad(at)).first()) }
            expect((if (at < 4) "frame.turn_x" else "frame.x_mm") in found.message!!) { "$found" }
        }
    }
    test("a lens") {
        // Android's order is the C interface's.
        same(Lens.ofAndroid(floatArrayOf(1f, 2f, 3f, 4f, 5f)), Lens(k1 = 1f, k2 = 2f, k3 = 3f, p1 = 4f, p2 = 5f), "the order")
        fails<IllegalArgumentException> { Lens.ofAndroid(floatArrayOf(1f, 2f, 3f, 4f, 5f, 6f)) }
        // Each coefficient reaches the library: a single one that is not a number is refused.
        for (lens in (0..4).map { at -> Lens.ofAndroid(FloatArray(5) { if (it == at) Float.NaN else 0f }) }) {
            FitSession(clip.camera.copy(lens = lens), models, quick).use { session ->
                val bad = fails<Im2fitException> { session.push(clip.frames().first()) }
                expect("frame.k1, k2, k3, p1, p2" in bad.message!!) { "$bad" }
            }
        }
        // A picture that is straight is not measured as the same person when a lens is undone that it never saw.
        val straight = FitSession(clip.camera, models, quick).use { it.measure(clip.frames()) }
        val bent = clip.camera.copy(lens = Lens(k1 = 0.1f))
        val other = FitSession(bent, models, quick).use { it.measure(clip.frames()) }
        expect(other != straight) { "the lens changes nothing" }
        // A frame's own camera counts, as its focal length does.
        same(FitSession(clip.camera, models, quick).use { session ->
            session.measure(clip.frames().map {
                DepthFrame(it.pixels, it.format, timeNs = it.timeNs, sequence = it.sequence, camera = bent)
            })
        }, other, "the lens of frames")
    }
    test("models from memory and from inside a file") {
        fun content(file: ModelFile?) = (file as ModelFile.Path).file.readBytes()
        val bytes = Models(ModelFile.Bytes(content(models.tracker)), ModelFile.Bytes(content(models.index)))
        FitSession(clip.camera, bytes, quick).use { expect(it.measure(clip.frames()) is Outcome.Measured) { "not measured" } }
    }
    test("a pack reaches the library whole, from a file and from memory") {
        // Of another version: the library alone reads packs, and refuses this one by name.
        val old = "I2PK".toByteArray() + byteArrayOf(1, 0, 0, 0)
        val file = File.createTempFile("models", ".i2p").apply { writeBytes(old) }
        for ((pack, name) in listOf(Models.of(file) to file.name, Models.ofPack(ModelFile.Bytes(old)) to "settings.pack_data")) {
            val refused = fails<Im2fitException> { FitSession(clip.camera, pack, quick).close() }
            val text = refused.message!!
            expect(name in text && "is a model pack of format 1, older than the 2" in text) { "$refused" }
        }
        file.delete()
    }
    test("a state is reported when it changes, and no frame is taken ahead") {
        FitSession(clip.camera, models, quick.copy(singleThread = true)).use { session ->
            var taken = 0
            val states = session.states(clip.frames().onEach { taken++ }).iterator()
            same(taken, 0, "frames before the first state")
            val first = states.next()
            same(taken, 1, "frames before the second state")
            expect(first.framesSeen == 1L) { "$first" }
            val all = listOf(first) + states.asSequence().toList()
            same(all.last().state, State.MEASURED, "the last state")
            same(all.last().joints.map { it.name }, JointName.values().toList(), "joints")
            session.reset()
            same(session.progress().state, State.SEARCHING, "after reset")
        }
    }
    test("the mask is the person's") {
        FitSession(clip.camera, models, quick.copy(singleThread = true)).use { session ->
            same(session.mask(), null, "a mask before the first frame")
            val frame = clip.frames().elementAt(1)
            session.push(frame)
            val mask = session.mask()!!
            val progress = session.progress()
            same(listOf(mask.width, mask.height), clip.camera.upright().let { listOf(it.width, it.height) }, "the size")
            same(listOf(mask.sequence, mask.timeNs), listOf(frame.sequence, frame.timeNs), "the frame")
            same(mask.userId, progress.userId, "the person")
            // The chest is the person's, the picture's corner is not.
            val chest = progress.joints.first { it.name == JointName.TO }.let { joint ->
                val k = clip.camera.upright()
                Math.round(k.fx * joint.x / joint.z + k.cx) to Math.round(k.fy * joint.y / joint.z + k.cy)
            }
            expect(mask[chest.first, chest.second] && !mask[0, 0]) { "chest at $chest" }
            expect(mask.pixels.all { it.toInt() == 0 || it.toInt() == -1 }) { "another value than 0 and 255" }
            val share = mask.pixels.count { it.toInt() != 0 }.toDouble() / mask.pixels.size
            expect(share in 0.03..0.5) { "the person has $share of the picture" }
            same(progress.framesWanted, 6L, "frames wanted")
            session.reset()
            same(session.mask(), null, "a mask after reset")
        }
    }
    test("guidance has words in five languages") {
        for (language in listOf("en", "de", "es", "fr", "zh"))
            same(Guidance.values().map { it.text(language) }.toSet().size, Guidance.values().size, "texts in $language")
        expect(Guidance.TOO_NEAR.text("de") != Guidance.TOO_NEAR.text()) { Guidance.TOO_NEAR.text() }
        fails<IllegalArgumentException> { Guidance.TOO_NEAR.text("xx") }
    }
    test("known facts are evidence") {
        FitSession(clip.camera, models, quick).use { session ->
            val before = (session.measure(clip.frames()) as Outcome.Measured).person
            same(before.knownUsed + before.knownDoubted, emptySet<KnownFact>(), "facts before any")
            fun with(known: Known): Person {
                session.setKnown(known)
                return (session.outcome() as Outcome.Measured).person
            }
            val weight = before[Measurement.WEIGHT].value + 5
            val weighed = with(Known(weightKg = weight, weightSdKg = 0.7f))
            same(weighed.knownUsed, setOf(KnownFact.WEIGHT), "facts used")
            expect(abs(weighed[Measurement.WEIGHT].value - weight) < 1.5f) { "${weighed[Measurement.WEIGHT]}, weighed $weight" }
            val tall = before[Measurement.STATURE].value + 15
            val all = with(Known(tall, weight, if (before.female > 0.5f) Sex.WOMAN else Sex.MAN, 40.5f, 5f, 0.7f, 0.4f))
            same(all.knownUsed, KnownFact.values().toSet(), "facts used")
            expect(abs(all.age.value - 40.5f) < 1) { "${all.age}" }
            expect(all[Measurement.STATURE].value > before[Measurement.STATURE].value + 5) { "${all[Measurement.STATURE]}" }
            same(with(Known(statureMm = 2450f)).knownDoubted, setOf(KnownFact.STATURE), "facts doubted")
            // Each number reaches the library: its text names the one that cannot be.
            val bad = mapOf(Known(statureMm = -1f) to "stature", Known(1700f, statureSdMm = -1f) to "stature",
                Known(weightKg = -1f) to "weight", Known(weightKg = 70f, weightSdKg = -1f) to "weight",
                Known(ageYears = -1f) to "age", Known(ageYears = 40f, ageSdYears = -1f) to "age")
            for ((known, word) in bad) {
                val refused = fails<Im2fitException> { session.setKnown(known) }
                expect(word in refused.message!!) { "$known: $refused" }
            }
            same(with(Known())[Measurement.WEIGHT], before[Measurement.WEIGHT], "weight once nothing is known")
        }
    }
    test("each turn asks for its own") {
        // The clip shows the front alone: a turn of the person is asked for, and the answer rests on the front.
        // The golden index knows no shapes. The one that other tests use does: with it a turn all round is asked for.
        val (tracker, index) = listOf("IM2FIT_TRACKER", "IM2FIT_INDEX").map { File(System.getenv(it) ?: "/nonexistent") }
        val with = if (tracker.exists() && index.exists()) {
            Models(ModelFile.Path(tracker), ModelFile.Path(index), models.body)
        } else models
        val shapes = FitSession(clip.camera, with, quick).use { it.modelInfo().answersShape }
        val asked = mapOf(Turn.NONE to null, Turn.BACK to Guidance.TURN_ROUND, Turn.AROUND to Guidance.TURN_ON, Turn.WALK to Guidance.WALK_ROUND)
            .filterKeys { shapes || it == Turn.NONE || it == Turn.BACK }
        if (!shapes) { // models that cannot measure a turn: AROUND alone is refused
            val refused = fails<Im2fitException> { FitSession(clip.camera, with, quick.copy(turn = Turn.AROUND)).close() }
            expect("all round" in refused.message!!) { "$refused" }
        }
        for ((turn, guidance) in asked) FitSession(clip.camera, with, quick.copy(turn = turn)).use { session ->
            for (frame in clip.frames()) session.push(frame)
            session.await()
            val last = session.progress()
            same(last.state, if (guidance == null) State.MEASURED else State.TURNING, "state with $turn")
            expect(guidance == null || guidance in last.guidance) { "guidance with $turn: ${last.guidance}" }
            expect(abs(last.turnedDeg) < 30) { "a person who stands still turned by ${last.turnedDeg} degrees" }
            val outcome = session.finish()
            expect(outcome is Outcome.Measured && outcome.person.views == Views.FRONT) { "$turn: $outcome" }
        }
    }
    test("a flow of frames gives the sequence's states") {
        val single = quick.copy(singleThread = true)
        val expected = FitSession(clip.camera, models, single).use { it.states(clip.frames()).toList() }
        FitSession(clip.camera, models, single).use { session ->
            var taken = 0
            val states = session.states(flow<DepthFrame> {
                for (frame in clip.frames()) {
                    taken++
                    emit(frame)
                }
            })
            same(taken, 0, "frames before it is collected")
            same(collected(states), expected, "states")
            expect(taken <= clip.depth.size && session.outcome() is Outcome.Measured) { "$taken frames, ${session.outcome()}" }
        }
        val noFrames = flow<DepthFrame> { error("no camera") }
        val broken = { FitSession(clip.camera, models, single).use { collected(it.states(noFrames)) } }
        same(fails<IllegalStateException> { broken() }.message, "no camera", "a camera that fails")
    }
    test("a screen asks from another thread, and a closed session says so") {
        val session = FitSession(clip.camera, models, quick)
        val ending = AtomicBoolean()
        val polls = AtomicLong()
        val screen = thread {
            try {
                while (!ending.get()) {
                    val mask = session.mask()
                    expect(mask == null || mask.userId != 0 || mask.pixels.all { it == 0.toByte() }) { "pixels of nobody" }
                    polls.addAndGet(session.progress().framesSeen.coerceAtMost(1))
                }
            } catch (closed: IllegalStateException) {
                expect("closed" in closed.message!!) { "$closed" }
            }
        }
        expect(session.measure(clip.frames()) is Outcome.Measured) { "not measured" }
        session.close()
        session.close()
        ending.set(true)
        screen.join()
        fails<IllegalStateException> { session.progress() }
        fails<IllegalStateException> { session.push(clip.frames().first()) }
    }
    feederTests(models)
    arCoreTests(models, clip)
    sampleAppTests(models, clip)
    test("two hundred sessions") {
        repeat(200) { FitSession(clip.camera, models, quick.copy(singleThread = true)).close() }
    }
    println("SdkTest: ${ran.size} tests passed")
}

/** All that a flow emits; nothing here suspends. */
fun <T> collected(flow: Flow<T>): List<T> {
    val all = mutableListOf<T>()
    val collecting: suspend () -> Unit = {
        flow.collect(object : FlowCollector<T> {
            override suspend fun emit(value: T) {
                all += value
            }
        })
    }
    collecting.startCoroutine(object : Continuation<Unit> {
        override val context = EmptyCoroutineContext
        override fun resumeWith(result: kotlin.Result<Unit>) = result.getOrThrow()
    })
    return all
}

/** Each value, interval and probability to the digits that the program prints. */
fun measuresAsProgram(clip: Clip, models: Models, output: String) = FitSession(clip.camera, models, quick).use { session ->
    val outcome = session.measure(clip.frames())
    // The same numbers in the same words, but for where the frames came from.
    // And but for what the program adds at the end: who made it, and figures of the body.
    fun lines(json: String) =
        json.substringAfter("\"views\"").substringBefore(",\n  \"made_by\"").trim().removeSuffix("\n}").lines()
    val (library, program) = lines(session.json()) to lines(output)
    for ((line, pair) in library.zip(program).withIndex()) same(pair.first, pair.second, "line $line of result.json")
    same(library.size, program.size, "lines of result.json")
    val measured = "\"state\": \"MEASURED\"" in output
    same(outcome is Outcome.Measured, measured, "measured")
    if (outcome !is Outcome.Measured) return@use
    val person = outcome.person
    var compared = 0
    fun close(found: Float, printed: String, what: String) {
        val digits = printed.substringAfter('.', "").length
        compared++
        expect(abs(found - printed.toFloat()) <= 0.5001 * Math.pow(10.0, -digits.toDouble()) + 1e-6 * abs(found)) {
            "$what is $found, im2fit says $printed"
        }
    }
    val number = "\\s*(-?[\\d.]+)\\s*"
    fun estimateAfter(text: String, key: String) =
        Regex("\"$key\": \\{\\s*\"value\":$number,\\s*\"unit\": \"\\w+\",\\s*\"interval\": \\[$number,$number]").find(text)!!
            .groupValues.drop(1)
    val values = output.substringAfter("\"measurements\"")
    for (measurement in Measurement.values()) {
        val (value, low, high) = estimateAfter(values, measurement.id)
        close(person[measurement].value, value, measurement.id)
        close(person[measurement].low, low, measurement.id)
        close(person[measurement].high, high, measurement.id)
    }
    close(person.age.value, estimateAfter(output, "age")[0], "age")
    close(person.female, Regex("\"female\":$number").find(output)!!.groupValues[1], "female")
    same(person.size.best, Regex("\"best\": \"([^\"]*)\"").find(output)!!.groupValues[1], "size")
    for ((size, probability) in person.size.probabilities) {
        close(probability, Regex("\"${Regex.escape(size)}\":$number").find(output.substringAfter("\"probabilities\""))!!.groupValues[1], size)
    }
    val tape = session.tape()
    val tapeOutput = output.substringAfter("\"tape\"")
    for (id in listOf("thigh_girth", "across_back", "head_girth")) {
        val value = tape.getValue(id)
        if (value is TapeValue.Measured) close(value.estimate.value, estimateAfter(tapeOutput, id)[0], id)
        else expect((value as TapeValue.Refused).reason.length > 10) { "$id has neither value nor reason" }
    }
    expect(compared >= 3 * 11 + 2 + person.size.probabilities.size + 1) { "only $compared values compared" }
    val shirt = session.fit("t_shirt")
    val shirtOutput = output.substringAfter("\"garment\": \"t_shirt\"")
    same(shirt.best.size, Regex("\"best\": \"([^\"]*)\"").find(shirtOutput)!!.groupValues[1], "the T-shirt's size")
    same(!shirt.noneFits, "\"fits\": true" in shirtOutput.substringBefore("\"garment\""), "whether one fits")
    val bestOutput = shirtOutput.substringAfter("\"${shirt.best.size}\": {")
    for ((place, found) in shirt.best.places) {
        val words = Regex("\"$place\": \\{\\s*\"ease_mm\":$number,\\s*\"interval\": \\[$number,$number],\\s*\"verdict\": \"(\\w+)\"")
            .find(bestOutput)!!.groupValues.drop(1)
        close(found.ease.value, words[0], "ease at the $place")
        close(found.ease.low, words[1], "least ease at the $place")
        close(found.ease.high, words[2], "most ease at the $place")
        same(found.fit.name.toLowerCase(), words[3], "fit at the $place")
    }
    same(shirt.best.places.size, 4, "places of a T-shirt")
    val dressed = session.dressedAvatar()
    same(String(dressed.copyOf(4)), "glTF", "the dressed .glb")
    expect("\"name\":\"t_shirt\"" in String(dressed, Charsets.ISO_8859_1)) { "no T-shirt is worn" }
    expect(session.dressedAvatar(listOf(Worn("t_shirt"))).contentEquals(
        session.dressedAvatar(listOf(Worn("t_shirt", shirt.best.size))))) { "the best size is another" }
    same(fails<Im2fitException> { session.dressedAvatar(listOf(Worn("t_shirt", "?"))) }.statusName, "not_found", "a size")
    fails<IllegalArgumentException> { session.dressedAvatar(List(5) { Worn("t_shirt") }) }
    same(fails<Im2fitException> { session.fit("toga") }.statusName, "not_found", "a garment")
    val rig = session.rig()!!
    expect(rig.root[1] in 0.6f..1.2f) { "hips at ${rig.root[1]} m" }
    for (q in rig.rotations.toList().chunked(4)) {
        expect(abs(q.map { it * it }.sum() - 1) < 1e-4) { "a quaternion of $q" }
    }
    expect(rigNodes().withIndex().all { (i, node) -> node.parent < i }) { "parents come first" }
    val mesh = session.mesh()
    val heights = mesh.vertices.filterIndexed { i, _ -> i % 3 == 1 }
    expect(abs(heights.min()!!) < 0.01f) { "soles at ${heights.min()}" }
    expect(abs(heights.max()!! - person[Measurement.STATURE].value) < 60) { "mesh of ${heights.max()} mm" } // posed
    same(mesh.triangles.max()!! + 1, mesh.vertices.size / 3, "vertices used")
    val waist = session.residual().getValue(Measurement.WAIST_GIRTH)
    val taped = (tape.getValue("waist_girth") as TapeValue.Measured).estimate.value // the mesh's
    expect(abs(taped - person[Measurement.WAIST_GIRTH].value - waist) < 0.2f) { "$waist mm of residual, the tape says $taped" }
    same(String(session.avatar(Avatar.GLB).copyOf(4)), "glTF", ".glb")
    expect(String(session.avatar(Avatar.BVH)).startsWith("HIERARCHY")) { ".bvh" }
    expect(String(session.avatar(Avatar.OBJ)).startsWith("# im2fit avatar")) { ".obj" }
}
